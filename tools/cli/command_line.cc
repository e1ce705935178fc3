// SPDX-License-Identifier: Apache-2.0
#include <gflags/gflags.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/errors.h"
#include "physics/util/stored/build.h"
#include "physics/util/text_format.h"
#include "tools/cli/option_text.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

constexpr std::array kGlogFlags = {"v",       "vmodule",     "logtostderr",     "alsologtostderr",
                                   "log_dir", "minloglevel", "stderrthreshold", "colorlogtostderr"};
constexpr char kWhere[] = "command line";

// One argument "--key=text", "--key text", "--switch" or "--noswitch".
struct Flag {
  std::string key;
  std::optional<std::string> text;
};

bool IsGlogFlag(const std::string& key) {
  return std::find(kGlogFlags.begin(), kGlogFlags.end(), key) != kGlogFlags.end();
}

const Option* Find(const OptionTable& table, const std::string& key) {
  const auto has_key = [&](const Option& option) { return option.key == key; };
  const auto it = std::find_if(table.options.begin(), table.options.end(), has_key);
  return it == table.options.end() ? nullptr : &*it;
}

bool IsSwitch(const OptionTable& table, const std::string& key) {
  const Option* option = Find(table, key);
  if (option != nullptr) return std::holds_alternative<bool*>(option->value);
  gflags::CommandLineFlagInfo info;
  return gflags::GetCommandLineFlagInfo(key.c_str(), &info) && info.type == "bool";
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
  const bool known = flag.key == "config" || Find(table, flag.key) || IsGlogFlag(flag.key);
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
    if (argument == "--help=words") return CompletionWords(table);
    if (argument == "--help=all" || argument == "-help=all") scope = HelpScope::kAll;
    const bool asked = argument == "--help" || argument == "-help" || argument == "-h";
    if (asked && !scope) scope = HelpScope::kCommon;
  }
  if (!scope) return {};
  return table.Help(*scope);
}

void SetGlogFlag(const Flag& flag) {
  // Verbose lines are INFO, which the programs otherwise leave out.
  if (flag.key == "v") gflags::SetCommandLineOption("minloglevel", "0");
  if (!gflags::SetCommandLineOption(flag.key.c_str(), flag.text->c_str()).empty()) return;
  throw InputError(kWhere, "option '" + flag.key + "': found '" + *flag.text +
                               "', expected a value that glog takes");
}

// Notes a value that makes another run of the one that is repeated.
void SetOption(const OptionTable& table, const Flag& flag, StoredRun* repeated) {
  const Option* option = Find(table, flag.key);
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
  for (const Flag& flag : flags) {
    if (IsGlogFlag(flag.key)) {
      SetGlogFlag(flag);
    } else {
      SetOption(table, flag, repeated.get());
    }
  }
  if (table.operands != nullptr && !(repeated && operands.empty())) {
    if (repeated && operands != *table.operands) repeated->is_changed = true;
    *table.operands = operands;
  }
  table.CheckRequired();
  if (run != nullptr) *run = repeated;
  return ParseOutcome::kRun;
}

}  // namespace drape
