// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/studies/gradients/gradients_tool.h"

int main(int argc, char** argv) {
  drape::GradientsOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    drape::Progress progress("gradients");
    const auto report = [&](double fraction, const std::string& note) {
      progress.Update(fraction, note);
    };
    const drape::GradientStudy study = drape::StudyGradients(options, {&cancel, report});
    std::printf("%s", drape::GradientReportText(study).c_str());
    return study.cancelled ? drape::kExitCancelled : drape::kExitOk;
  };
  return drape::RunTool(argc, argv, drape::GradientsTable(options), body);
}
