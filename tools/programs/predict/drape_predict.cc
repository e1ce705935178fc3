// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/predict/predict_report.h"
#include "tools/programs/predict/predict_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const PredictToolOptions& options, const RunControl& control) {
  const PredictionRun run = RunPrediction(options, control);
  return {.text = PredictionText(run),
          .cancelled = run.cancelled,
          .failure = run.at_rest() > 0 ? "" : "no sample came to rest, see summary.json"};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::PredictTable, drape::Run);
}
