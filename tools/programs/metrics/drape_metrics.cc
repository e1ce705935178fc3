// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/run_tool.h"
#include "tools/programs/metrics/metrics_tool.h"

int main(int argc, char** argv) {
  drape::MetricsOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    std::printf("%s", drape::RunMetrics(options, cancel).c_str());
    return cancel ? drape::kExitCancelled : drape::kExitOk;
  };
  return drape::RunTool(argc, argv, drape::MetricsTable(options), body);
}
