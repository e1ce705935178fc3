// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "losses/metrics/metrics.h"
#include "tests/physics/file_fixture.h"
#include "tests/tools/run_process.h"

namespace drape::test {

inline const std::string kSimulate = std::string(DRAPE_BIN_DIR) + "/drape_simulate";
inline const std::string kCheck = std::string(DRAPE_BIN_DIR) + "/drape_check";
inline const std::string kFit = std::string(DRAPE_BIN_DIR) + "/drape_fit";
inline const std::string kFabric =
    std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/cotton_blue.json";

// Exactly one line on stderr that holds `text`, and exit code 2. With a sanitizer, progress and
// what was skipped may stand beside the error.
inline void ExpectOneLineError(const ProcessResult& result, const std::string& text) {
  std::string err = kSlowdown > 1.0 ? "" : result.err;
  std::istringstream lines(result.err);
  for (std::string line; kSlowdown > 1.0 && std::getline(lines, line);)
    if (line.find(": error: ") != std::string::npos) err += line + "\n";
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << result.err;
  EXPECT_THAT(err, testing::HasSubstr(": error: "));
  EXPECT_THAT(err, testing::HasSubstr(text));
}

// Runs the real programs in a folder of the test's own.
class ToolFixture : public FileFixture {
 protected:
  using Json = nlohmann::json;

  Json ReadJson(const std::string& path) const { return Json::parse(Read(path)); }

  // A small drape of a few steps; `more` come last and win.
  std::vector<std::string> SimulateCommand(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {kSimulate, "--mesh=disc:120", "--steps=3",
                                        "--fabric=" + kFabric, "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  ProcessResult Simulate(const std::vector<std::string>& more = {},
                         const ProcessLimits& limits = {}) const {
    return RunProcess(SimulateCommand(more), limits);
  }

  std::string AddDisc(const std::string& name, double radius) const {
    const std::filesystem::path path = Path(name);
    std::filesystem::create_directories(path.parent_path());
    WritePng(ObserveDisc(radius, Camera(), {}).image, path.string());
    return path.string();
  }

  // Four samples of radii 9.7 to 10.6 cm, captures 1 to 4, the down side 2 mm wider.
  std::string AddData() const {
    for (int sample = 1; sample <= 4; ++sample)
      for (int capture = 1; capture <= 4; ++capture)
        AddDisc("set/data/Fabric 3/silhouettes/Sample_" + std::to_string(sample) + "_Capture_" +
                    std::to_string(capture) + ".png",
                0.094 + 0.003 * sample + (capture > 2 ? 0.002 : 0));
    Write("set/data/Fabric 3/silhouettes/Sample_5_Capture_1.png", "no image");
    return Path("set");
  }

  // Name → content of all files below a folder.
  std::map<std::string, std::string> Snapshot(const std::string& folder) const {
    std::map<std::string, std::string> files;
    if (!std::filesystem::exists(folder)) return files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
      files[entry.path().string()] = entry.is_regular_file() ? Read(entry.path()) : "folder";
    return files;
  }
};

}  // namespace drape::test
