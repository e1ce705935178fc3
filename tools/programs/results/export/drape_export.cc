// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/results/export/export_report.h"
#include "tools/programs/results/export/export_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const ExportToolOptions& options, const RunControl& control) {
  const ExportRun run = RunExport(options, control);
  return {.text = ExportText(run), .cancelled = run.cancelled};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::ExportTable, drape::Run);
}
