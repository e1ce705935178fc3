// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/garment/garment_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const GarmentOptions& options, const RunControl& control) {
  const GarmentResult result = RunGarments(options, control);
  return {.text = GarmentText(result),
          .cancelled = result.cancelled,
          .failure = GarmentFailure(result)};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::GarmentTable, drape::Run);
}
