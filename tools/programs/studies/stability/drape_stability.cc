// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/stability/stability_report.h"
#include "tools/programs/studies/stability/stability_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const StabilityOptions& options, const RunControl& control) {
  if (options.cells.list) return {.text = ListStabilityText(options)};
  const StabilityAtlas atlas = RunStability(options, control);
  if (!options.cells.share.empty())
    return {.text = StabilityShareText(options, atlas), .cancelled = atlas.cancelled};
  return {.text = StabilityTableText(atlas), .cancelled = atlas.cancelled};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::StabilityTable, drape::Run);
}
