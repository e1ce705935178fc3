// SPDX-License-Identifier: Apache-2.0
// Attacks the programs and readers with bad input, as README.md says.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <set>

#include "physics/util/errors.h"
#include "tests/attack/classes/classes.h"
#include "tests/attack/inputs/valid_inputs.h"
#include "tools/cli/option_table.h"

namespace drape::attack {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::vector<std::string> classes;
  bool brief = false, thorough = false;
  int seed = 1, jobs = 2;
  std::string programs = DRAPE_BIN_DIR, work, read, file;
};

OptionTable FlagTable(Flags& flags) {
  std::string names;
  for (const AttackClass& one : AttackClasses()) names += (names.empty() ? "" : ",") + one.name;
  return {.tool = "attack",
          .summary = "bad input for every program and reader",
          .example = "attack --long --seed=2 --classes=options,files",
          .notes =
              "Prints each failure with a command that reproduces it and a table by class.\n"
              "exit codes: 1 when an attack failed\n",
          .options = {{.key = "classes", .value = &flags.classes, .doc = "of " + names},
                      {.key = "short", .value = &flags.brief, .doc = "a minute; the default"},
                      {.key = "long", .value = &flags.thorough, .doc = "all of every table"},
                      {.key = "seed",
                       .value = &flags.seed,
                       .doc = "random seed of choices, damage and times",
                       .range = {.least = 0}},
                      {.key = "jobs",
                       .value = &flags.jobs,
                       .doc = "attacks that run side by side",
                       .range = {.least = 1, .most = 64}},
                      {.key = "programs",
                       .value = &flags.programs,
                       .doc = "folder of the built programs",
                       .is_path = true},
                      {.key = "work",
                       .value = &flags.work,
                       .doc = "folder that keeps the inputs of failures; none: a temporary one",
                       .is_path = true},
                      {.key = "read",
                       .value = &flags.read,
                       .doc = "only reads 'file' by this reader, in process, as for a mutant"},
                      {.key = "file", .value = &flags.file, .doc = "see 'read'", .is_path = true}}};
}

std::string MakeWorkFolder(const std::string& wanted) {
  if (!wanted.empty()) {
    fs::create_directories(wanted);
    return fs::canonical(wanted).string();
  }
  std::string pattern = (fs::temp_directory_path() / "attack_XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw InputError(pattern, "cannot be made");
  return pattern;
}

std::vector<AttackClass> ChooseClasses(const std::vector<std::string>& names) {
  std::vector<AttackClass> chosen;
  std::set<std::string> wanted(names.begin(), names.end());
  for (const AttackClass& one : AttackClasses())
    if (names.empty() || wanted.erase(one.name) > 0) chosen.push_back(one);
  if (!wanted.empty())
    throw InputError("option 'classes'", "unknown class '" + *wanted.begin() + "'");
  return chosen;
}

int Replay(const CampaignOptions& options, const Flags& flags) {
  const std::vector<std::string> reasons = ReadOnce(options, flags.read, flags.file);
  for (const std::string& reason : reasons) std::printf("%s\n", Visible(reason).c_str());
  return reasons.empty() ? 0 : 1;
}

int Run(const Flags& flags) {
  if (flags.brief && flags.thorough)
    throw InputError("option 'short'", "given with 'long', expected one of them");
  const std::string work = MakeWorkFolder(flags.work);
  MakeValidInputs(work, DRAPE_SOURCE_DIR);
  const CampaignOptions options{.programs = fs::canonical(flags.programs).string(),
                                .sources = DRAPE_SOURCE_DIR,
                                .work = work,
                                .seed = static_cast<uint64_t>(flags.seed),
                                .thorough = flags.thorough,
                                .jobs = flags.jobs};
  if (!flags.read.empty()) return Replay(options, flags);
  Campaign campaign(options);
  for (const AttackClass& one : ChooseClasses(flags.classes)) one.run(&campaign);
  const bool passed = campaign.PrintTable();
  if (passed && flags.work.empty()) fs::remove_all(work);
  return passed ? 0 : 1;
}

}  // namespace
}  // namespace drape::attack

int main(int argc, char** argv) {
  using namespace drape;
  try {
    attack::Flags flags;
    if (ParseCommandLine(attack::FlagTable(flags), argc, argv) == ParseOutcome::kHelpShown)
      return 0;
    return attack::Run(flags);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "attack: error: %s\n", error.what());
    return 2;
  }
}
