// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/option_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/options/names_file.h"
#include "physics/util/stored/build.h"
#include "physics/util/text_format.h"
#include "tools/cli/option_text.h"
#include "tools/cli/program_folder.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

// The place and the text of a value, for an error.
struct Given {
  const Option& option;
  std::string where;   // "command line: option 'time_step'"
  std::string found;   // the text as the user gave it
  std::string folder;  // that paths are relative to; empty: the working directory

  [[noreturn]] void Fail(const std::string& expected, const std::string& hint = "") const {
    const std::string range = RangeText(option);
    const std::string unit = option.unit.empty() ? "" : " " + option.unit;
    throw InputError(where, "found " + found + ", expected " + expected +
                                (range.empty() ? "" : ", " + range + unit) + hint);
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
  const double least = std::max(option.range.least, option.usual_least),
               most = std::min(option.range.most, option.usual_most);
  if (!option.range.Contains(number))
    given.Fail(expected, UnitHint(number, option.unit, least, most));
  if (number != 0) CheckUsual(given.where, number, option.unit, least, most);
  return number;
}

bool IsNoPath(const Option& option, const std::string& text) {
  return std::any_of(option.words.begin(), option.words.end(), [&](const std::string& word) {
    return word.back() == ':' ? text.starts_with(word) : text == word;
  });
}

// The file of a name that stands for one of configs/; empty where it is none.
std::string FindPreset(const Given& given, const std::string& text) {
  namespace fs = std::filesystem;
  if (given.option.presets.empty() || text.find_first_of("./#") != text.npos ||
      fs::exists(fs::path(given.folder) / text))
    return "";
  try {
    const std::string file =
        FindConfigs(ProgramFolder(), "presets") + "/" + given.option.presets + "/" + text + ".json";
    return fs::exists(file) ? file : "";
  } catch (const InputError&) {  // no configs beside the programs
    return "";
  }
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
  if (!option.is_path || text.empty() || IsNoPath(option, text)) return text;
  if (std::string preset = FindPreset(given, text); !preset.empty()) return preset;
  if (given.folder.empty()) return text;
  return (std::filesystem::path(given.folder) / text).string();
}

bool ParseSwitch(const Given& given, const std::string& text) {
  if (text == "true" || text == "1") return true;
  if (text != "false" && text != "0") given.Fail("true or false");
  return false;
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
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

// Sets the options of an earlier run, with its paths as they were. Defaults are left alone: a
// default may be a value that users may not give.
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
  const Option* option = Find(key);
  if (option == nullptr) throw InputError(where, "unknown option '" + key + "'");
  const Given given{*option, where + ": option '" + key + "'", "'" + text + "'", ""};
  const auto parts = !IsList(option->value) ? std::vector<std::string>{text}
                     : option->is_path      ? SplitPaths(text)
                                            : SplitAtCommas(text);
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

const Option* OptionTable::Find(const std::string& key) const {
  for (const Option& option : options)
    if (option.key == key) return &option;
  return nullptr;
}

void OptionTable::CheckRequired() const {
  for (const Option& option : options) {
    if (!option.required || !IsUnset(option)) continue;
    throw InputError("option '" + option.key + "'",
                     "is missing, expected " + option.doc + " (see --help)");
  }
}

namespace {

constexpr char kWhere[] = "command line";

// One argument "--key=text", "--key text", "--switch" or "--noswitch".
struct Flag {
  std::string key;
  std::optional<std::string> text;
};

bool IsSwitch(const OptionTable& table, const std::string& key) {
  const Option* option = table.Find(key);
  return option != nullptr && std::holds_alternative<bool*>(option->value);
}

// Levenshtein's distance.
int Distance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 0; i < a.size(); ++i) {
    int diagonal = row[0]++;
    for (size_t j = 0; j < b.size(); ++j) {
      const int change = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({change, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

[[noreturn]] void FailUnknown(const OptionTable& table, const std::string& key) {
  std::vector<std::string> names = {"config"};
  for (const Option& option : table.options) names.push_back(option.key);
  const std::string nearest = SuggestName(key, names);
  throw InputError(kWhere, "unknown option '--" + key + "'" +
                               (nearest.empty() ? "" : ", did you mean '--" + nearest + "'?") +
                               " (--help=all lists all)");
}

// Splits an argument and, takes the next argument as its value where there is no "=".
Flag ReadFlag(const OptionTable& table, int argc, char** argv, int& i) {
  const std::string argument = argv[i];
  if (argument.size() < 2 || argument[0] != '-') {
    throw InputError(kWhere, "found '" + argument + "', expected --key=value (see --help)");
  }
  const size_t begin = argument[1] == '-' ? 2 : 1, equals = argument.find('=');
  Flag flag{argument.substr(begin, equals == std::string::npos ? equals : equals - begin), {}};
  if (equals != std::string::npos) flag.text = argument.substr(equals + 1);
  const bool known = flag.key == "config" || table.Find(flag.key) != nullptr;
  if (!known && flag.key.starts_with("no") && IsSwitch(table, flag.key.substr(2)) && !flag.text) {
    return {flag.key.substr(2), "false"};
  }
  if (!known) FailUnknown(table, flag.key);
  if (flag.text) return flag;
  if (IsSwitch(table, flag.key)) return {flag.key, "true"};
  if (i + 1 >= argc) throw InputError(kWhere, "option '--" + flag.key + "' has no value");
  flag.text = argv[++i];
  return flag;
}

// The help that the command line asks for.
std::optional<std::string> AskedHelp(const OptionTable& table, int argc, char** argv) {
  std::optional<HelpScope> scope;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--help=man") return ManPage(table);
    if (argument == "--help=all" || argument == "-help=all") scope = HelpScope::kAll;
    const bool asked = argument == "--help" || argument == "-help" || argument == "-h";
    if (asked && !scope) scope = HelpScope::kCommon;
  }
  if (!scope) return {};
  return table.Help(*scope);
}

// Notes a value that makes another run of the one that is repeated.
void SetOption(const OptionTable& table, const Flag& flag, StoredRun* repeated) {
  const Option* option = table.Find(flag.key);
  const std::string before = ValueText(*option);
  table.Set(flag.key, *flag.text, kWhere);
  if (repeated != nullptr && option->repeated && ValueText(*option) != before)
    repeated->is_changed = true;
}

}  // namespace

std::string SuggestName(const std::string& written, const std::vector<std::string>& names) {
  std::string nearest;
  int least = static_cast<int>(written.size() + 1) / 2;
  for (const std::string& name : names) {
    const int distance = Distance(written, name);
    if (distance > least || (distance == least && !nearest.empty())) continue;
    nearest = name;
    least = distance;
  }
  return nearest;
}

nlohmann::json OptionSettings(const OptionTable& table, const std::set<std::string>& free) {
  nlohmann::json settings;
  for (const Option& option : table.options) {
    if (free.contains(option.key) || !option.repeated) continue;
    if (const std::string value = ValueText(option); !NamesFile(value, option))
      settings[option.key] = value;
  }
  return settings;
}

ParseOutcome ParseCommandLine(const OptionTable& table, int argc, char** argv,
                              std::shared_ptr<const StoredRun>* run) {
  if (const std::optional<std::string> help = AskedHelp(table, argc, argv)) {
    std::fputs(help->c_str(), stdout);
    return ParseOutcome::kHelpShown;
  }
  std::vector<Flag> flags;
  std::vector<std::string> operands;
  std::string config;
  for (int i = 1; i < argc; ++i) {
    if (argv[i] == std::string("--version")) {
      std::printf("%s %s\n", table.tool.c_str(), BuildVersion().c_str());
      return ParseOutcome::kHelpShown;
    }
    if (table.operands != nullptr && argv[i][0] != '-') {
      operands.push_back(argv[i]);
      if (!IsUtf8(operands.back()))
        throw InputError(kWhere, "found '" + operands.back() + "', expected UTF-8 text");
      continue;
    }
    const Flag flag = ReadFlag(table, argc, argv, i);
    if (flag.key == "config") {
      config = *flag.text;
    } else {
      flags.push_back(flag);
    }
  }
  const std::shared_ptr<StoredRun> repeated = config.empty() ? nullptr : table.ReadConfig(config);
  for (const Flag& flag : flags) SetOption(table, flag, repeated.get());
  if (table.operands != nullptr && !(repeated && operands.empty())) {
    if (repeated && operands != *table.operands) repeated->is_changed = true;
    *table.operands = operands;
  }
  table.CheckRequired();
  if (run != nullptr) *run = repeated;
  return ParseOutcome::kRun;
}

}  // namespace drape
