// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "tools/cli/tool_main.h"
#include "tools/programs/studies/bench/speed_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const SpeedToolOptions& options, const RunControl& control) {
  SpeedToolResult result = RunSpeedTool(options, control);
  return {.text = std::move(result.text), .cancelled = result.table.cancelled};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::SpeedOptionTable, drape::Run);
}
