// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/optimisers_report.h"
#include "tools/progress.h"
#include "tools/run_tool.h"

namespace {

drape::Race Run(const drape::OptimisersOptions& options, const std::atomic<bool>& cancel) {
  drape::Progress progress("optimisers");
  return drape::RunRace(options, {&cancel, [&](double fraction, const std::string& note) {
                                    progress.Update(fraction, note);
                                  }});
}

}  // namespace

int main(int argc, char** argv) {
  drape::OptimisersOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::Race race = Run(options, cancel);
    for (const std::string& note : race.notes) std::printf("%s\n", note.c_str());
    if (!race.problems.empty())
      std::printf("%s", drape::MethodTableText(race, options.branch_tolerance).c_str());
    if (race.cancelled) return drape::kExitCancelled;
    if (!race.problems.empty()) return drape::kExitOk;
    std::fprintf(stderr, "drape_optimisers: failed: no problem has a start\n");
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::OptimisersTable(options), body);
}
