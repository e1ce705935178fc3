// SPDX-License-Identifier: Apache-2.0
// Each option of each program with bad, extreme and hostile values. The options are those that
// --help=all lists.
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/option_list.h"
#include "tests/attack/inputs/valid_inputs.h"

namespace drape::attack {
namespace {

constexpr std::size_t kFewOptions = 60;  // of a short campaign
constexpr double kSecondsToRead = 60.0;  // an endless file, up to the limit of all files
constexpr double kOptionsSeconds = 4.0;  // after which a run that took the value is cancelled

// An option that needs another one beside it.
std::vector<std::string> CompanionsFor(const std::string& program, const std::string& key) {
  if (key == "accuracy_table") return {"--accuracy=fast"};
  if (key == "table") return {"--solve=hybrid"};
  const bool of_data = key == "data" || key == "data_fabric" || key == "samples" ||
                       key == "captures" || key == "train" || key == "split_seed" ||
                       key == "split" || key == "save_split" || key == "face";
  if (of_data && (program == "drape_predict" || program == "drape_metrics"))
    return {"--data=" + std::string(kValid) + "set", "--train=2"};
  return {};
}

std::vector<std::string> MakeCommand(const std::string& program, const ListedOption& option,
                                     const std::string& value) {
  std::vector<std::string> command = QuickCommand(program, CompanionsFor(program, option.key));
  if (program == "drape_metrics" && !CompanionsFor(program, option.key).empty())
    command.erase(command.begin() + 1);  // its operand
  command.push_back("--" + option.key + "=" + value);
  return command;
}

// An error names the option or the value, as far as it can be printed. A number within its range
// may be refused for what it does to another input, which the error then names.
std::vector<std::string> FindNames(const ListedOption& option, const OptionValue& value) {
  const bool is_number = option.type == OptionType::kInteger || option.type == OptionType::kNumber;
  const bool is_pattern = value.text.find_first_of("*?[") != std::string::npos;
  const bool is_choice = option.type == OptionType::kChoice;
  if ((is_number || is_choice || is_pattern) && !value.refused) return {};
  constexpr std::size_t kLongest = 20;
  std::vector<std::string> names = {option.key};
  std::string run;
  for (const unsigned char c : value.text + '\n') {
    const bool printable = c > 0x20 && c < 0x7f && std::strchr(",:#", c) == nullptr;
    if (printable && run.size() < kLongest) run += static_cast<char>(c);
    if (printable || run.empty()) continue;
    names.push_back(run);
    run.clear();
  }
  return names.size() > 1 ? names : std::vector<std::string>();
}

std::string WithoutSlash(const std::string& path) {
  std::string plain = std::filesystem::path(path).lexically_normal();
  while (plain.size() > 1 && plain.back() == '/') plain.pop_back();
  return plain;
}

// Where the value of an option may be written to.
std::vector<std::string> FindResults(const ListedOption& option, const std::string& value) {
  std::vector<std::string> results = {"out"};
  for (const char* key : {"out", "csv", "statistics", "overlay", "table", "save_split"})
    if (option.key == key) results.push_back(WithoutSlash(value));
  return results;
}

void TryValue(const Campaign& campaign, const std::string& program, const ListedOption& option,
              const OptionValue& value, bool has_results, Sandbox& sandbox) {
  if (has_results) AddEarlierResults(&sandbox);
  sandbox.Write("here/notes.txt", "earlier");
  if (program == "drape_metrics" && !has_results) sandbox.Write("out/notes.txt", "earlier");
  Request request = MakeRequest(campaign, MakeCommand(program, option, value.text));
  request.limits.seconds = kOptionsSeconds;
  if (option.key == "threads") request.limits.memory_gb = 0;  // stacks take address space only
  sandbox.Run(request, {.verdict = value.refused ? Verdict::kRefused : Verdict::kAny,
                        .named = FindNames(option, value),
                        .results = FindResults(option, value.text)});
}

std::vector<ListedOption> ListOptions(const Campaign& campaign, const std::string& program) {
  const Outcome help =
      RunProgramIn(campaign.options().work, {.command = {campaign.Program(program), "--help=all"}});
  if (help.exit_code != 0) throw std::runtime_error(program + " --help=all failed");
  return ParseHelp(help.out);
}

void AddCommandLines(const Campaign& campaign, const std::string& program,
                     std::vector<Attack>* attacks) {
  const std::vector<std::vector<std::string>> lines = {{"--no_such_option=1"},
                                                       {"--"},
                                                       {"operand\x1b[31m"},
                                                       {"--=1"},
                                                       {"---out=x"},
                                                       {"--config=no.json"},
                                                       {"--config=tmp"},
                                                       {"--config=/dev/zero"},
                                                       {"-x"},
                                                       {std::string(5000, 'y')},
                                                       {"--\xff=1"},
                                                       {"--help=none"},
                                                       {"--out"},
                                                       {"--\n=1"},
                                                       {"--config"}};
  for (const std::vector<std::string>& line : lines)
    attacks->push_back({program + " " + line.front(), [&campaign, program, line](Sandbox& sandbox) {
                          AddEarlierResults(&sandbox);
                          Request request = MakeRequest(campaign, QuickCommand(program, line));
                          request.limits.seconds = kSecondsToRead;
                          sandbox.Run(request, {.verdict = Verdict::kRefused});
                        }});
}

}  // namespace

void AttackOptions(Campaign* campaign) {
  std::vector<Attack> attacks;
  for (const std::string& program : ProgramNames()) {
    for (const ListedOption& option : ListOptions(*campaign, program)) {
      for (const OptionValue& value : MakeValues(option)) {
        const bool has_results = attacks.size() % 2 == 0;
        attacks.push_back({program + " --" + option.key + "=" + value.text, [=](Sandbox& sandbox) {
                             TryValue(*campaign, program, option, value, has_results, sandbox);
                           }});
      }
    }
    AddCommandLines(*campaign, program, &attacks);
  }
  campaign->Run("options", std::move(attacks), kFewOptions);
}

}  // namespace drape::attack
