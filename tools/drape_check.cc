// SPDX-License-Identifier: Apache-2.0
#include "tools/check_report.h"
#include "tools/run_tool.h"
#include "tools/tool_options.h"

int main(int argc, char** argv) {
  drape::CheckToolOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::LoadedScene scene = drape::LoadScene(options.scene);
    options.check.cancel = &cancel;
    const auto rows =
        drape::CheckScene(scene.model, scene.material.field, scene.start, options.check);
    drape::PrintCheckTable(rows);
    if (cancel) return drape::kExitCancelled;
    return drape::AllHold(rows) ? drape::kExitOk : drape::kExitCheckFailed;
  };
  return drape::RunTool(argc, argv, drape::CheckTable(options), body);
}
