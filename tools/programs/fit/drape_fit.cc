// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/fit/fit_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const FitToolOptions& options, const RunControl& control) {
  FitJobResult result = RunFitTool(options, control);
  return {.text = std::move(result.table),
          .cancelled = result.cancelled,
          .failure = result.fitted ? "" : "nothing could be fitted, see summary.json"};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) { return drape::ToolMain(argc, argv, drape::FitTable, drape::Run); }
