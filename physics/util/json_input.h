// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace drape {

// JSON from outside the program. All errors are InputErrors "where: key 'a[1].b': found …, expected
// …". This header only declares nlohmann::json: a .cc file that uses values includes
// <nlohmann/json.hpp>.

// Parses text that may contain // and /* */ comments. Throws InputError for a syntax error (with
// line and column), a duplicate key, more than 64 levels and a number outside the range of double.
nlohmann::json ParseJson(const std::string& text, const std::string& where);
nlohmann::json ReadJsonFile(const std::string& path);

// A value together with its place in the file, so that every error can name it. The value must
// outlive the object.
class JsonInput {
 public:
  JsonInput(const nlohmann::json& value, std::string where, std::string key = "")
      : value_(value), where_(std::move(where)), key_(std::move(key)) {}

  JsonInput(nlohmann::json&& temporary, std::string where, std::string key = "") = delete;

  const nlohmann::json& value() const { return value_; }
  std::string Name() const { return key_.empty() ? where_ : where_ + ": key '" + key_ + "'"; }
  bool Has(const std::string& key) const;  // whether the value is an object with that key

  // Members and elements. Throw InputError unless the value is an object with that key, or an array
  // that has that element or is of that size.
  JsonInput At(const std::string& key) const;
  JsonInput At(int index) const;
  const JsonInput& ExpectArray() const;
  const JsonInput& ExpectArray(int size) const;
  const JsonInput& ExpectObject() const;
  // Throws InputError, which lists the allowed keys, unless the value is an object without other
  // keys.
  const JsonInput& ExpectKeys(const std::vector<std::string>& allowed) const;

  int Size() const;       // number of members or elements
  double Number() const;  // throws InputError unless the value is a finite number
  int Integer() const;
  std::string String() const;
  bool Boolean() const;
  // A number ≥ 0, or of [least, most].
  double NotNegative() const;
  double NumberWithin(double least, double most) const;
  int IntegerWithin(int least, int most) const;
  // An array of numbers; the second has that size.
  Eigen::VectorXd Vector() const;
  Eigen::VectorXd Vector(int size) const;

  [[noreturn]] void Fail(const std::string& expected) const;  // "found <value>, expected …"

 private:
  const nlohmann::json& value_;
  std::string where_;
  std::string key_;
};

}  // namespace drape
