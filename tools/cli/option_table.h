// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "physics/util/options/field.h"

namespace drape {

struct StoredRun;

// One option of a tool.
using Option = Field;

// The option of an enum, by the names of its values.
template <NamedEnum E>
Option EnumOption(E& value, Option option) {
  option.value = EnumField{[&value] { return std::string(ToString(value)); },
                           [&value, where = "option '" + option.key + "'"](
                               const std::string& text) { value = ParseName<E>(text, where); }};
  for (const auto& [named, name] : EnumNames(E{})) option.choices.push_back(name);
  return option;
}
template <NamedEnum E>
Option EnumOption(const std::string& key, E& value, const std::string& doc) {
  return EnumOption(value, {.key = key, .doc = doc});
}

// The options of a struct whose fields are described (VisitFields), in the order of their visit.
// Points into `options`, which outlives them.
template <class Options>
std::vector<Option> FieldOptionList(Options& options) {
  std::vector<Option> list;
  VisitFields(options, [&](auto& value, Option field) {
    using T = std::remove_reference_t<decltype(value)>;
    if (!field.is_option) return;
    if constexpr (NamedEnum<T>) {
      list.push_back(EnumOption(value, std::move(field)));
    } else if constexpr (std::is_constructible_v<Option::Value, T*>) {
      field.value = &value;
      list.push_back(std::move(field));
    }
  });
  return list;
}

// The options under one heading of --help=all.
std::vector<Option> Grouped(const std::string& group, std::vector<Option> options);

// Options that no repetition of a run takes over.
std::vector<Option> OfOneRun(std::vector<Option> options);

// All options, or words, of several lists.
template <class List, class... Lists>
List Concatenate(List all, const Lists&... lists) {
  (all.insert(all.end(), lists.begin(), lists.end()), ...);
  return all;
}

enum class HelpScope {
  kCommon,  // the options that most runs need, and how to see the others
  kAll      // every option, under its heading
};

// The options of one tool: the command line, the config file and --help follow from it.
struct OptionTable {
  std::string tool;     // "drape_simulate"
  std::string summary;  // one line: what the tool does
  std::string example;  // a command line
  std::string notes;    // files and exit codes, for --help: one paragraph a line
  std::vector<Option> options;
  // Keys of the options that --help shows, in its order; the others are left to --help=all. Empty:
  // --help shows all.
  std::vector<std::string> common = {};
  // The words of the command line beside options, in order, and their names in the usage line;
  // nullptr: there are none.
  std::vector<std::string>* operands = nullptr;
  std::string operand_names = {};
  // If not nullptr, gets the keys that the user has set, by flag or config.
  std::set<std::string>* given = nullptr;

  // The names, types, defaults, ranges, units and docs of the options, in lines of at most 100
  // columns. A line that begins with "  --" begins an option.
  std::string Help(HelpScope scope = HelpScope::kCommon) const;

  // Sets an option from text, as on a command line: "--key=text". Throws InputError that starts
  // with `where`, names the key and the text, and says what was expected.
  void Set(const std::string& key, const std::string& text, const std::string& where) const;

  // Sets what a config file gives: a flat JSON object whose keys are those of the table (//
  // comments are allowed), or a summary of this program, whose options and operands are in its
  // member "provenance". Returns the run of a summary, else nullptr. Throws InputError naming the
  // file and the key; an unknown key lists the allowed.
  std::shared_ptr<StoredRun> ReadConfig(const std::string& path) const;

  // The option of a key; nullptr: there is none.
  const Option* Find(const std::string& key) const;

  // InputError unless each required option has a value.
  void CheckRequired() const;
};

// The values of the options that results depend on, as text: without paths, whose contents a key of
// stored work holds, and the options of `free`.
nlohmann::json OptionSettings(const OptionTable& table, const std::set<std::string>& free);

enum class ParseOutcome { kRun, kHelpShown };

// Reads the command line into the table's fields: --config=FILE first, then the flags on top of it
// (--key=value, --key value, --switch, --noswitch). --help prints the common options, --help=all
// all of them, and asks to end; --version too. *run, where given: that of a config which is a
// summary. Throws InputError for an unknown flag (it suggests the nearest), a missing value, and
// whatever Set, ReadConfig and CheckRequired throw.
ParseOutcome ParseCommandLine(const OptionTable& table, int argc, char** argv,
                              std::shared_ptr<const StoredRun>* run = nullptr);

}  // namespace drape
