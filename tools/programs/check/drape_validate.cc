// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/check/validate.h"

int main(int argc, char** argv) {
  drape::ValidateToolOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    drape::Progress progress("validate");
    options.validation.cancel = &cancel;
    options.validation.progress = [&](double fraction, const std::string& group) {
      progress.Update(fraction, group);
    };
    const auto truths = drape::RunValidation(options);
    if (cancel) return drape::kExitCancelled;
    return drape::AllPass(truths) ? drape::kExitOk : drape::kExitCheckFailed;
  };
  return drape::RunTool(argc, argv, drape::ValidateTable(options), body);
}
