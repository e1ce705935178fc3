// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/results/report/report_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const ReportOptions& options, const RunControl& control) {
  std::string text = RunReport(options, control);
  return {.text = std::move(text), .cancelled = control.cancelled()};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::ReportTable, drape::Run);
}
