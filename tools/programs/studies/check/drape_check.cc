// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/check/check_report.h"

namespace drape {
namespace {

ToolOutcome Run(const CheckToolOptions& options, const RunControl& control) {
  const LoadedScene scene = LoadScene(options.scene);
  RequireOneTable(scene.material, "material");
  const std::vector<CheckRow> rows =
      CheckScene(scene.model, scene.material.field, scene.start, options.check, control);
  return {.text = CheckTableText(rows),
          .cancelled = control.cancelled(),
          .exit_code = AllPass(rows) ? kExitOk : kExitCheckFailed};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::CheckTable, drape::Run);
}
