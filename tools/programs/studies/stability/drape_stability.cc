// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/studies/stability/stability_report.h"

int main(int argc, char** argv) {
  drape::StabilityOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    drape::Progress progress("stability");
    const auto report = [&](double fraction, const std::string& note) {
      progress.Update(fraction, note);
    };
    const drape::StabilityAtlas atlas = drape::MakeStabilityAtlas(options, {&cancel, report});
    std::printf("%s", drape::StabilityTableText(atlas).c_str());
    return atlas.cancelled ? drape::kExitCancelled : drape::kExitOk;
  };
  return drape::RunTool(argc, argv, drape::StabilityTable(options), body);
}
