// SPDX-License-Identifier: Apache-2.0
// drape_gradients as a user runs it.
#include <cmath>

#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kGradients = std::string(DRAPE_BIN_DIR) + "/drape_gradients";
const std::string kGradientWool =
    std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json";

class GradientsTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more = {},
                    const ProcessLimits& limits = {}) const {
    std::vector<std::string> command = {
        kGradients,         "--mesh=disc:100", "--fabric=" + kGradientWool, "--horizons=1,5",
        "--time_steps=0.1", "--fold_starts=1", "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }
};

TEST_F(GradientsTool, FindsTangentsByDifferencesAndAFoldAsTheorySays) {
  const ProcessResult result = Run({"--start_seed=4"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string report = Read(Path("out/report.md"));
  EXPECT_THAT(report, testing::StartsWith("| difference step |"));
  EXPECT_THAT(result.out, testing::StartsWith("difference step  "));
  EXPECT_THAT(result.out, testing::Not(testing::HasSubstr("|")));
  const Json study = ReadJson(Path("out/gradients.json"));
  EXPECT_EQ(study["outcome"], "done");
  ASSERT_EQ(study["cells"].size(), 5u);
  int sweeps = 0;
  for (const Json& cell : study["cells"]) {
    const Json& result = cell["result"];
    const std::string part = cell["input"]["part"];
    for (const Json& sweep : part == "differences" ? result : Json::array()) {
      double best = 1.0;
      for (const Json& error : sweep["errors"])
        if (!error["error"].is_null()) best = std::min(best, error["error"].get<double>());
      EXPECT_LT(best, 1e-4) << sweep["of"];
      ++sweeps;
    }
    if (part == "horizons") {
      EXPECT_EQ(result["steps"], Json({1, 5}));
      for (const Json& error : result["errors"]) EXPECT_LT(error["error"].get<double>(), 1e-4);
    }
    if (part != "branches") continue;
    EXPECT_GT(result["points"].back()["speed_m"].get<double>(),
              10 * result["points"].front()["speed_m"].get<double>());
  }
  EXPECT_EQ(sweeps, 4);  // two laws, after steps and at rest
  const std::size_t last = report.rfind("| ", report.rfind(" |") - 1);  // exponent by eigenvalue
  EXPECT_NEAR(std::stod(report.substr(last + 2)), -1.0, 0.1) << report;
  for (const char* chart : {"differences.png", "horizons.png", "fold.png"})
    EXPECT_GT(Read(Path(std::string("out/") + chart)).size(), 1000u) << chart;
}

TEST_F(GradientsTool, ABranchWithoutAnEndLeavesAnEmptyChart) {
  const ProcessResult result = Run({"--start_seed=1"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("reached the end"));
  EXPECT_GT(Read(Path("out/fold.png")).size(), 1000u);
}

TEST_F(GradientsTool, MistakesAreOneLine) {
  ExpectOneLineError(Run({"--horizons=0"}), "horizons");
  ExpectOneLineError(Run({"--time_steps=-1"}), "time_steps");
  ExpectOneLineError(Run({"--mesh=disc:2"}), "disc");
  ExpectOneLineError(Run({"--fabric=" + Path("none.json")}), "none.json");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

}  // namespace
}  // namespace drape::test
