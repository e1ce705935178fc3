// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace drape {

// JSON from outside the program. For .cc files: public headers of this folder do not show nlohmann.
// All errors are InputErrors "where: key 'a[1].b': found …, expected …".

// Parses text that may hold // and /* */ comments. Throws InputError (syntax, with line and column;
// a key given twice; a number beyond the range of double).
nlohmann::json ParseJson(const std::string& text, const std::string& where);
nlohmann::json ReadJsonFile(const std::string& path);

// A value with the place where it stands, so that each error can name it.
class JsonInput {
 public:
  JsonInput(const nlohmann::json& value, std::string where, std::string key = "")
      : value_(value), where_(std::move(where)), key_(std::move(key)) {}

  JsonInput(nlohmann::json&& temporary, std::string where, std::string key = "") = delete;

  const nlohmann::json& value() const { return value_; }
  std::string Name() const { return where_ + ": key '" + key_ + "'"; }
  bool Has(const std::string& key) const { return value_.is_object() && value_.contains(key); }

  // Members and elements; the value must be an object with that key, or an array of that size.
  JsonInput At(const std::string& key) const;
  JsonInput At(int index) const;
  const JsonInput& ExpectArray() const;
  const JsonInput& ExpectArray(int size) const;
  const JsonInput& ExpectObject() const;
  // An object without other keys; lists the allowed ones.
  const JsonInput& ExpectKeys(const std::vector<std::string>& allowed) const;

  int Size() const { return static_cast<int>(value_.size()); }
  double Number() const;  // finite
  int Integer() const;
  std::string String() const;

  [[noreturn]] void Fail(const std::string& expected) const;  // "found <value>, expected …"

 private:
  const nlohmann::json& value_;
  std::string where_;
  std::string key_;
};

}  // namespace drape
