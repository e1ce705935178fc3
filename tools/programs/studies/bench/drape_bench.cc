// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/bench/bench_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const BenchToolOptions& options, const RunControl& control) {
  BenchToolResult result = RunBenchTool(options, control);
  if (result.is_list) return {.text = std::move(result.table), .cancelled = result.cancelled};
  return {.text = std::move(result.table),
          .cancelled = result.cancelled,
          .failure = result.measured > 0 ? result.no_table : "no run has a result, see bench.json"};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::BenchTable, drape::Run);
}
