// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/measure/photo/photo_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const PhotoToolOptions& options, const RunControl& control) {
  return {.text = RunPhoto(options, control), .cancelled = control.cancelled()};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::PhotoTable, drape::Run);
}
