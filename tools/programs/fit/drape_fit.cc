// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/fit/fit_tool.h"

namespace {

drape::FitJobResult Run(const drape::FitToolOptions& options, const std::atomic<bool>& cancel) {
  drape::Progress progress("fit");
  const auto report = [&](const drape::FitProgress& done) {
    progress.Update(done.fraction, drape::ProgressNote(done));
  };
  const auto say = [&](const std::string& line) { progress.Say(line); };
  return drape::RunFitTool(options, {&cancel, report, say});
}

}  // namespace

int main(int argc, char** argv) {
  drape::FitToolOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::FitJobResult result = Run(options, cancel);
    std::printf("%s", result.table.c_str());
    if (result.cancelled) return drape::kExitCancelled;
    if (result.fitted) return drape::kExitOk;
    std::fprintf(stderr, "drape_fit: failed: nothing could be fitted, see summary.json\n");
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::FitTable(options), body);
}
