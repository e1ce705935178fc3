// SPDX-License-Identifier: Apache-2.0
#include "physics/util/json_input.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using nlohmann::json;

// A short description by which a user recognises the value in an error message.
std::string Describe(const json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  constexpr size_t kLongest = 60;
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return text.size() <= kLongest ? text : text.substr(0, kLongest) + "…";
}

constexpr int kMostDepth = 64;  // of lists and objects; some work on values is recursive

// nlohmann keeps the last of two equal keys; a user who wrote both must be informed.
class ContentCheck {
 public:
  explicit ContentCheck(const std::string& where) : where_(where) {}

  bool operator()(int depth, json::parse_event_t event, const json& parsed) {
    if (depth >= kMostDepth &&
        (event == json::parse_event_t::object_start || event == json::parse_event_t::array_start))
      throw InputError(where_, Format("found values nested deeper than %d, expected at most %d",
                                      kMostDepth, kMostDepth));
    if (event == json::parse_event_t::object_start) keys_.emplace_back();
    if (event == json::parse_event_t::object_end) keys_.pop_back();
    if (event == json::parse_event_t::key &&
        !keys_.back().insert(parsed.get<std::string>()).second) {
      throw InputError(where_, "key '" + parsed.get<std::string>() + "' is given twice");
    }
    return true;
  }

 private:
  const std::string& where_;
  std::vector<std::set<std::string>> keys_;
};

// "[json.exception.parse_error.101] parse error …; last read: '…'": without the first part, and of
// what was read, which may be all of the text, the end.
std::string DescribeSyntaxError(std::string_view message) {
  constexpr std::string_view kRead = "last read: '";
  constexpr std::size_t kShown = 60;
  std::string text(message.substr(message.find("] ") + 2));
  const std::size_t read = text.find(kRead);
  if (read != std::string::npos && text.size() - read > kRead.size() + kShown)
    text.replace(read + kRead.size(), text.size() - read - kRead.size() - kShown, "…");
  return text;
}

}  // namespace

json ParseJson(const std::string& text, const std::string& where) {
  // To the parser a NUL is the end of the text, and what follows would be left out.
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos)
    throw InputError(where, "found a NUL at byte " + std::to_string(nul + 1) + ", expected text");
  ContentCheck check(where);
  try {
    return json::parse(
        text,
        [&](int depth, json::parse_event_t event, json& parsed) {
          return check(depth, event, parsed);
        },
        /*allow_exceptions=*/true, /*ignore_comments=*/true);
  } catch (const json::exception& error) {
    throw InputError(where, DescribeSyntaxError(error.what()));
  }
}

json ReadJsonFile(const std::string& path) { return ParseJson(ReadWholeFile(path), path); }

bool JsonInput::Has(const std::string& key) const {
  return value_.is_object() && value_.contains(key);
}

int JsonInput::Size() const { return static_cast<int>(value_.size()); }

void JsonInput::Fail(const std::string& expected) const {
  throw InputError(Name(), "found " + Describe(value_) + ", expected " + expected);
}

const JsonInput& JsonInput::ExpectObject() const {
  if (!value_.is_object()) Fail("an object");
  return *this;
}

const JsonInput& JsonInput::ExpectArray() const {
  if (!value_.is_array()) Fail("an array");
  return *this;
}

const JsonInput& JsonInput::ExpectArray(int size) const {
  if (!value_.is_array() || Size() != size) Fail("an array of " + std::to_string(size));
  return *this;
}

const JsonInput& JsonInput::ExpectKeys(const std::vector<std::string>& allowed) const {
  ExpectObject();
  for (const auto& [key, unused] : value_.items()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    std::string list;
    for (const std::string& name : allowed) list += ' ' + name;
    const std::string place = key_.empty() ? "" : key_ + ".";
    throw InputError(where_,
                     "unknown key '" + MakePrintableLine(place + key) + "', allowed:" + list);
  }
  return *this;
}

JsonInput JsonInput::At(const std::string& key) const {
  ExpectObject();
  const std::string place = key_.empty() ? key : key_ + "." + key;
  const auto it = value_.find(key);
  if (it == value_.end()) throw InputError(where_, "key '" + place + "' is missing");
  return {*it, where_, place};
}

JsonInput JsonInput::At(int index) const {
  ExpectArray();
  if (index < 0 || index >= Size()) Fail("an array with an element " + std::to_string(index));
  return {value_.at(index), where_, key_ + "[" + std::to_string(index) + "]"};
}

double JsonInput::Number() const {
  if (!value_.is_number() || !std::isfinite(value_.get<double>())) Fail("a finite number");
  return value_.get<double>();
}

int JsonInput::Integer() const {
  const double number = value_.is_number_integer() ? value_.get<double>() : NAN;
  const bool fits =
      number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max();
  if (!fits) Fail("a whole number");
  return value_.get<int>();
}

double JsonInput::NotNegative() const {
  const double number = Number();
  if (number < 0) Fail("a number that is not negative");
  return number;
}

double JsonInput::NumberWithin(double least, double most) const {
  const double number = Number();
  if (number < least || number > most) Fail(Format("a number from %g to %g", least, most));
  return number;
}

int JsonInput::IntegerWithin(int least, int most) const {
  const int number = Integer();
  if (number < least || number > most) Fail(Format("a whole number from %d to %d", least, most));
  return number;
}

bool JsonInput::Boolean() const {
  if (!value_.is_boolean()) Fail("true or false");
  return value_.get<bool>();
}

Eigen::VectorXd JsonInput::Vector() const {
  Eigen::VectorXd numbers(ExpectArray().Size());
  for (int i = 0; i < numbers.size(); ++i) numbers[i] = At(i).Number();
  return numbers;
}

Eigen::VectorXd JsonInput::Vector(int size) const { return ExpectArray(size).Vector(); }

std::string JsonInput::String() const {
  if (!value_.is_string()) Fail("a string");
  return value_.get<std::string>();
}

}  // namespace drape
