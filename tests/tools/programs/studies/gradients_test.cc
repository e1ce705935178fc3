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
        kGradients,        "--mesh=disc:100",     "--material=" + kGradientWool,
        "--horizons=1,5",  "--time_steps=0.1",    "--sweep_horizon=5",
        "--fold_starts=1", "--out=" + Path("out")};
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
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary["outcome"], "done");
  ASSERT_EQ(summary["differences"].size(), 4u);  // two laws, after steps and at rest
  for (const Json& sweep : summary["differences"]) {
    double best = 1.0;
    for (const Json& error : sweep["errors"])
      if (!error["error"].is_null()) best = std::min(best, error["error"].get<double>());
    EXPECT_LT(best, 1e-4) << sweep["of"];
  }
  for (const Json& series : summary["horizons"]) {
    EXPECT_EQ(series["steps"], Json({1, 5}));
    for (const Json& error : series["errors"]) EXPECT_LT(error["error"].get<double>(), 1e-4);
  }
  ASSERT_EQ(summary["branches"].size(), 1u);
  const Json& branch = summary["branches"][0];
  EXPECT_GT(branch["points"].back()["speed_m"].get<double>(),
            10 * branch["points"].front()["speed_m"].get<double>());
  EXPECT_NEAR(branch["exponent_by_eigenvalue"].get<double>(), -1.0, 0.1);
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
  ExpectOneLineError(Run({"--material=" + Path("none.json")}), "none.json");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

}  // namespace
}  // namespace drape::test
