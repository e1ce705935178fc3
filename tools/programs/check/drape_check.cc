// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/check/check_report.h"

namespace {

std::vector<drape::CheckRow> Run(drape::CheckToolOptions& options,
                                 const std::atomic<bool>& cancel) {
  const drape::LoadedScene scene = drape::LoadScene(options.scene);
  drape::Progress progress("check");
  options.check.cancel = &cancel;
  options.check.progress = [&](double fraction, const std::string& note) {
    progress.Update(fraction, note);
  };
  return drape::CheckScene(scene.model, scene.material.field, scene.start, options.check);
}

}  // namespace

int main(int argc, char** argv) {
  drape::CheckToolOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const auto rows = Run(options, cancel);
    drape::PrintCheckTable(rows);
    if (cancel) return drape::kExitCancelled;
    return drape::AllPass(rows) ? drape::kExitOk : drape::kExitCheckFailed;
  };
  return drape::RunTool(argc, argv, drape::CheckTable(options), body);
}
