// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/studies/optimisers/optimisers_report.h"

namespace {

drape::OptimiserBenchmark Run(const drape::OptimiserBenchmarkOptions& options,
                              const std::atomic<bool>& cancel) {
  drape::Progress progress("optimisers");
  return drape::RunOptimiserBenchmark(options,
                                      {&cancel, [&](double fraction, const std::string& note) {
                                         progress.Update(fraction, note);
                                       }});
}

}  // namespace

int main(int argc, char** argv) {
  drape::OptimiserBenchmarkOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::OptimiserBenchmark race = Run(options, cancel);
    for (const std::string& note : race.notes) std::printf("%s\n", note.c_str());
    if (!race.problems.empty())
      std::printf("%s", drape::MethodTableText(race, options.branch_tolerance).c_str());
    if (race.cancelled) return drape::kExitCancelled;
    if (!race.problems.empty()) return drape::kExitOk;
    std::fprintf(stderr, "drape_compare_optimisers: failed: no problem has a start\n");
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::OptimiserBenchmarkTable(options), body);
}
