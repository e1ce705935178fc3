// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/optimisers/optimisers_report.h"
#include "tools/programs/studies/optimisers/optimisers_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const OptimiserBenchmarkOptions& options, const RunControl& control) {
  if (options.cells.list) return {.text = ListOptimiserText(options)};
  const OptimiserBenchmark benchmark = RunBenchmarkTool(options, control);
  std::string text;
  for (const std::string& note : benchmark.notes) text += note + "\n";
  if (!options.cells.share.empty())
    return {.text = text + ShareText(options.cells.share, benchmark.done, benchmark.cells),
            .cancelled = benchmark.cancelled};
  const bool has_problems = !benchmark.problems.empty();
  if (has_problems) text += MakeMethodTable(benchmark, options.branch_tolerance).Aligned();
  return {.text = std::move(text),
          .cancelled = benchmark.cancelled,
          .failure = has_problems ? "" : "no problem has a start"};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::OptimiserBenchmarkTable, drape::Run);
}
