// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/predict/predict_report.h"

namespace {

drape::PredictionRun Run(const drape::PredictToolOptions& options,
                         const std::atomic<bool>& cancel) {
  drape::Progress progress("predict");
  const auto report = [&](double fraction, const std::string& note) {
    progress.Update(fraction, note);
  };
  const auto say = [&](const std::string& line) { progress.Say(line); };
  return drape::RunPrediction(options, {&cancel, report, say});
}

}  // namespace

int main(int argc, char** argv) {
  drape::PredictToolOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::PredictionRun run = Run(options, cancel);
    std::printf("%s", drape::PredictionText(run).c_str());
    if (run.cancelled) return drape::kExitCancelled;
    if (run.at_rest() > 0) return drape::kExitOk;
    std::fprintf(stderr, "drape_predict: failed: no draw came to rest, see summary.json\n");
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::PredictTable(options), body);
}
