// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/tools/tool_fixture.h"

namespace drape::test {

inline const std::string kConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs/";
inline const std::string kWool = kConfigs + "fabrics/synthetic_wool.json";
inline const std::string kWaves = kConfigs + "starts/six_waves.json";

// Control bytes that a terminal acts on.
inline bool HasControls(const std::string& text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7f;
  });
}

// One line for a person: printable and short.
inline void ExpectRefused(const ProcessResult& result, const std::string& text) {
  ExpectOneLineError(result, text);
  EXPECT_FALSE(HasControls(result.err)) << result.err;
  EXPECT_LT(result.err.size(), 430u);
}

// Runs the programs in a folder of their own, from where a command in a name would write to it.
class Hostile : public ToolFixture {
 protected:
  ProcessResult Run(const std::string& program, const std::vector<std::string>& options,
                    ProcessLimits limits = {}) const {
    std::vector<std::string> command = {std::string(DRAPE_BIN_DIR) + "/drape_" + program};
    command.insert(command.end(), options.begin(), options.end());
    limits.folder = Path("");
    return RunProcess(command, limits);
  }

  std::string Copy(const std::string& file, const std::string& name) const {
    std::filesystem::copy(file, Path(name));
    return name;
  }

  // One drape, for its silhouette.
  std::string AddSilhouette(const std::string& name) const {
    EXPECT_EQ(Run("simulate", {"--mesh=disc:100", "--fabric=" + kWool, "--start=" + kWaves,
                               "--steps=40", "--time_step=0.1", "--out=drape"})
                  .exit_code,
              0);
    return Copy(Path("drape/silhouette.png"), name);
  }

  static std::vector<std::string> FitOptions(const std::string& image) {
    return {"--images=" + image,
            "--fabric=" + kWool,
            "--mesh=disc:100",
            "--coarse_mesh=disc:100",
            "--candidates_per_round=1",
            "--iterations=1",
            "--initial_stretch=1",
            "--initial_bend=1",
            "--initial_lifts=1",
            "--initial_steps=10",
            "--num_parameters=2",
            "--threads=1",
            "--out=fit"};
  }
};

class HostileFiles : public Hostile {
 protected:
  HostileFiles() { Copy(kWool, "wool.json"); }

  ProcessResult Drape(const std::vector<std::string>& more, ProcessLimits limits = {}) const {
    std::vector<std::string> options = {"--mesh=disc:100", "--fabric=wool.json", "--steps=2",
                                        "--out=out"};
    options.insert(options.end(), more.begin(), more.end());
    return Run("simulate", options, std::move(limits));
  }

  // Wool with another member.
  std::string WriteFabric(const std::string& name, const std::string& key,
                          const Json& value) const {
    Json fabric = ReadJson(kWool);
    fabric[key] = value;
    Write(name, fabric.dump());
    return name;
  }
};

}  // namespace drape::test
