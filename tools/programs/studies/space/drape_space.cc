// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/space/space_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const SpaceToolOptions& options, const RunControl& control) {
  SpaceResult result = RunSpaceTool(options, control);
  if (result.cancelled) result.text += "run the same command again to continue\n";
  return {.text = std::move(result.text), .cancelled = result.cancelled};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::SpaceTable, drape::Run);
}
