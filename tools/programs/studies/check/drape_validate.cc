// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/check/validate.h"

namespace drape {
namespace {

ToolOutcome Run(const ValidateToolOptions& options, const RunControl& control) {
  const std::vector<ReferenceCase> cases = RunValidation(options, control);
  return {.text = ValidationText(cases),
          .cancelled = control.cancelled(),
          .exit_code = AllPass(cases) ? kExitOk : kExitCheckFailed};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::ValidateTable, drape::Run);
}
