// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/simulate/simulate.h"

namespace {

drape::SimulateResult Run(const drape::SimulateOptions& options, const std::atomic<bool>& cancel) {
  drape::Progress progress("drape");
  const auto report = [&](double fraction, const std::string& note) {
    progress.Update(fraction, note);
  };
  const auto say = [&](const std::string& line) { progress.Say(line); };
  return drape::Simulate(options, {&cancel, report, say});
}

}  // namespace

int main(int argc, char** argv) {
  drape::SimulateOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::SimulateResult result = Run(options, cancel);
    std::printf("%s\n", result.line.c_str());
    if (result.outcome == drape::SimulateOutcome::kCancelled) return drape::kExitCancelled;
    if (result.outcome == drape::SimulateOutcome::kDone) return drape::kExitOk;
    std::fprintf(stderr, "drape_simulate: failed: %s\n", result.status.c_str());
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::SimulateTable(options), body);
}
