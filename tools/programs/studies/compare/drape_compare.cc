// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/studies/compare/compare_tool.h"

namespace {

drape::CompareResult Run(const drape::CompareToolOptions& options,
                         const std::atomic<bool>& cancel) {
  drape::Progress progress("compare");
  const auto report = [&](double fraction, const std::string& note) {
    progress.Update(fraction, note);
  };
  const auto say = [&](const std::string& line) { progress.Say(line); };
  return drape::RunCompareTool(options, {&cancel, report, say});
}

}  // namespace

int main(int argc, char** argv) {
  drape::CompareToolOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::CompareResult result = Run(options, cancel);
    std::printf("%s", result.text.c_str());
    if (!result.run.cancelled) return drape::kExitOk;
    std::printf("%d of %d cells are done: the same command goes on\n", result.run.done,
                result.run.cells);
    return drape::kExitCancelled;
  };
  return drape::RunTool(argc, argv, drape::CompareTable(options), body);
}
