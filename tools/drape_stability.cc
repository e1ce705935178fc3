// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/progress.h"
#include "tools/run_tool.h"
#include "tools/stability_report.h"

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
