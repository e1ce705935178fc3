// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/compare/compare_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const CompareToolOptions& options, const RunControl& control) {
  CompareResult result = RunCompareTool(options, control);
  if (result.run.cancelled)
    result.text += std::to_string(result.run.done) + " of " +
                   std::to_string(result.run.experiments) +
                   " experiments are complete; run the same command again to continue\n";
  return {.text = std::move(result.text), .cancelled = result.run.cancelled};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::CompareTable, drape::Run);
}
