// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/simulate/simulate_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const SimulateOptions& options, const RunControl& control) {
  const SimulateResult result = RunSimulate(options, control);
  const SimulationResult& simulation = result.simulation;
  return {.text = result.line + "\n",
          .cancelled = simulation.outcome == SimulationOutcome::kCancelled,
          .failure = simulation.outcome == SimulationOutcome::kFailed ? simulation.status : ""};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::SimulateTable, drape::Run);
}
