// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/studies/bench/bench_tool.h"

namespace {

drape::BenchToolResult Run(const drape::BenchToolOptions& options,
                           const std::atomic<bool>& cancel) {
  drape::Progress progress("bench");
  const auto report = [&](double fraction, const std::string& note) {
    progress.Update(fraction, note);
  };
  const auto say = [&](const std::string& line) { progress.Say(line); };
  return drape::RunBenchTool(options, {&cancel, report, say});
}

}  // namespace

int main(int argc, char** argv) {
  drape::BenchToolOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::BenchToolResult result = Run(options, cancel);
    std::printf("%s", result.table.c_str());
    if (result.cancelled) return drape::kExitCancelled;
    if (result.measured > 0) return drape::kExitOk;
    std::fprintf(stderr, "drape_bench: failed: no cell has a result, see cells.csv\n");
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::BenchTable(options), body);
}
