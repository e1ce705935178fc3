// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/option_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>

#include "physics/material/material_io.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"
#include "tools/cli/option_text.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

// Where a value comes from and what it is, for an error.
struct Given {
  const Option& option;
  std::string where;   // "command line: option 'time_step'"
  std::string found;   // the text as the user gave it
  std::string folder;  // that paths are relative to; empty: the working directory

  [[noreturn]] void Fail(const std::string& expected) const {
    const std::string range = RangeText(option);
    const std::string unit = option.unit.empty() ? "" : " " + option.unit;
    throw InputError(where, "found " + found + ", expected " + expected +
                                (range.empty() ? "" : ", " + range + unit));
  }
};

template <class Number>
Number ParseNumber(const Given& given, const std::string& text) {
  constexpr bool kWhole = std::is_same_v<Number, int>;
  const char* expected = kWhole ? "a whole number" : "a number";
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole_text = end == text.data() + text.size();
  if (error != std::errc() || !whole_text || !std::isfinite(static_cast<double>(number))) {
    given.Fail(expected);
  }
  const Option& option = given.option;
  const bool below = option.above_least ? number <= option.least : number < option.least;
  if (below || number > option.most) given.Fail(expected);
  return number;
}

bool IsNoPath(const Option& option, const std::string& text) {
  return std::any_of(option.words.begin(), option.words.end(), [&](const std::string& word) {
    return word.back() == ':' ? text.starts_with(word) : text == word;
  });
}

std::string ParseText(const Given& given, const std::string& text) {
  const Option& option = given.option;
  const auto& choices = option.choices;
  if (!choices.empty() && std::find(choices.begin(), choices.end(), text) == choices.end()) {
    given.Fail("one of " + JoinChoices(choices, ", "));
  }
  if (text.empty() && !option.words.empty())
    given.Fail("a file or " + JoinChoices(option.words, ", "));
  // Results name their inputs, and those are JSON.
  if (!IsUtf8(given.folder + text)) given.Fail("UTF-8 text");
  if (!option.is_path || text.empty() || given.folder.empty() || IsNoPath(option, text))
    return text;
  const std::filesystem::path folder = given.folder;
  const std::optional<BendingRow> row = SplitBendingRow(text);
  if (!row || row->base.empty() || IsNoPath(option, row->base)) return (folder / text).string();
  return (folder / row->table).string() + "#" + row->row + ":" + (folder / row->base).string();
}

bool ParseSwitch(const Given& given, const std::string& text) {
  if (text == "true" || text == "1") return true;
  if (text != "false" && text != "0") given.Fail("true or false");
  return false;
}

std::vector<std::string> Split(const std::string& text) {
  std::vector<std::string> parts;
  for (size_t begin = 0; !text.empty();) {
    const size_t comma = text.find(',', begin);
    parts.push_back(text.substr(begin, comma - begin));
    if (comma == std::string::npos) break;
    begin = comma + 1;
  }
  return parts;
}

template <class Item>
Item ParseItem(const Given& given, const std::string& text) {
  if constexpr (std::is_same_v<Item, std::string>) {
    return ParseText(given, text);
  } else if constexpr (std::is_same_v<Item, bool>) {
    return ParseSwitch(given, text);
  } else {
    return ParseNumber<Item>(given, text);
  }
}

// Each part is the text of one item; a scalar has one part.
struct AssignParts {
  const Given& given;
  const std::vector<std::string>& parts;

  void operator()(const EnumField& value) const {
    if (parts.size() != 1) given.Fail("a single value");
    value.set(ParseText(given, parts[0]));
  }
  template <class Item>
  void operator()(Item* value) const {
    if (parts.size() != 1) given.Fail("a single value");
    *value = ParseItem<Item>(given, parts[0]);
  }
  template <class Item>
  void operator()(std::vector<Item>* value) const {
    std::vector<Item> items;
    for (const std::string& part : parts) {
      if (given.option.is_path && part.empty()) given.Fail("paths that are not empty");
      items.push_back(ParseItem<Item>(given, part));
    }
    if (items.empty() && !value->empty()) given.Fail("at least one value");
    *value = std::move(items);
  }
};

template <class T>
constexpr bool kIsList = false;
template <class T>
constexpr bool kIsList<std::vector<T>> = true;

bool IsList(const Option::Value& value) {
  return std::visit(
      [](const auto& v) { return kIsList<std::remove_pointer_t<std::decay_t<decltype(v)>>>; },
      value);
}

bool HoldsText(const Option::Value& value) {
  return std::holds_alternative<std::string*>(value) || std::holds_alternative<EnumField>(value) ||
         std::holds_alternative<std::vector<std::string>*>(value);
}

// A JSON value as text; JSON's own type must fit, so "5" is no number and 5 is no path.
std::string PartFromJson(const Given& given, const nlohmann::json& json) {
  if (HoldsText(given.option.value)) {
    if (!json.is_string()) given.Fail("a text in quotes");
    return json.get<std::string>();
  }
  const bool is_switch = std::holds_alternative<bool*>(given.option.value);
  if (is_switch ? !json.is_boolean() : !json.is_number()) {
    given.Fail(is_switch ? "true or false" : "a number");
  }
  return json.dump();
}

std::vector<std::string> PartsFromJson(const Given& given, const nlohmann::json& json) {
  if (!IsList(given.option.value)) return {PartFromJson(given, json)};
  if (!json.is_array()) given.Fail("a list in brackets");
  std::vector<std::string> parts;
  for (const nlohmann::json& item : json) parts.push_back(PartFromJson(given, item));
  return parts;
}

const Option* FindOption(const OptionTable& table, const std::string& key) {
  for (const Option& option : table.options)
    if (option.key == key) return &option;
  return nullptr;
}

std::vector<std::string> ListKeys(const OptionTable& table) {
  std::vector<std::string> keys;
  for (const Option& option : table.options) keys.push_back(option.key);
  return keys;
}

void SetFromJson(const Option& option, const JsonInput& input, const std::string& folder) {
  const Given given{option, input.Name(), input.value().dump(), folder};
  const auto parts = PartsFromJson(given, input.value());
  std::visit(AssignParts{given, parts}, option.value);
}

std::vector<std::string> Strings(const JsonInput& list) {
  std::vector<std::string> texts;
  for (int i = 0; i < list.ExpectArray().Size(); ++i) texts.push_back(list.At(i).String());
  return texts;
}

// Those of a run, with its paths as they were. What is as it is by default is not set: a default
// may be a value that no user may give.
void TakeOptions(const OptionTable& table, const JsonInput& provenance) {
  const JsonInput values = provenance.At("options");
  values.ExpectKeys(ListKeys(table));
  for (const Option& option : table.options) {
    if (!values.Has(option.key) || !option.repeated) continue;
    const JsonInput value = values.At(option.key);
    if (!value.value().is_null() && value.value() != ValueJson(option))
      SetFromJson(option, value, "");
  }
  if (table.given != nullptr && provenance.Has("given"))
    for (const std::string& key : Strings(provenance.At("given"))) table.given->insert(key);
  if (table.operands != nullptr) *table.operands = Strings(provenance.At("operands"));
}

bool IsUnset(const Option& option) {
  if (const auto* text = std::get_if<std::string*>(&option.value)) return (*text)->empty();
  const auto* list = std::get_if<std::vector<std::string>*>(&option.value);
  return list != nullptr && (*list)->empty();
}

}  // namespace

void OptionTable::Set(const std::string& key, const std::string& text,
                      const std::string& where) const {
  const Option* option = FindOption(*this, key);
  if (option == nullptr) throw InputError(where, "unknown option '" + key + "'");
  const Given given{*option, where + ": option '" + key + "'", "'" + text + "'", ""};
  const auto parts = !IsList(option->value) ? std::vector<std::string>{text}
                     : option->is_path      ? SplitPaths(text)
                                            : Split(text);
  std::visit(AssignParts{given, parts}, option->value);
  if (this->given != nullptr) this->given->insert(key);
}

std::shared_ptr<StoredRun> OptionTable::ReadConfig(const std::string& path) const {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput config(file, path);
  if (config.Has("provenance")) {
    const JsonInput provenance = config.At("provenance");
    auto run = std::make_shared<StoredRun>(ReadStoredRun(provenance, path, tool));
    TakeOptions(*this, provenance);
    return run;
  }
  config.ExpectKeys(ListKeys(*this));
  const std::string folder = std::filesystem::path(path).parent_path().string();
  for (const Option& option : options) {
    if (!file.contains(option.key)) continue;
    SetFromJson(option, config.At(option.key), folder);
    if (given != nullptr) given->insert(option.key);
  }
  return nullptr;
}

void OptionTable::CheckRequired() const {
  for (const Option& option : options) {
    if (!option.required || !IsUnset(option)) continue;
    throw InputError("option '" + option.key + "'",
                     "is missing, expected " + option.doc + " (see --help)");
  }
}

}  // namespace drape
