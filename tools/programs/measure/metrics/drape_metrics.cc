// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/measure/metrics/metrics_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const MetricsOptions& options, const RunControl& control) {
  return {.text = RunMetrics(options, control), .cancelled = control.cancelled()};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::MetricsTable, drape::Run);
}
