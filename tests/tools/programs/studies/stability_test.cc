// SPDX-License-Identifier: Apache-2.0
// drape_stability as a user runs it.
#include "losses/image/image.h"
#include "tests/tools/tool_fixture.h"
#include "tools/programs/studies/stability/stability_tool.h"

namespace drape::test {
namespace {

const std::string kStability = std::string(DRAPE_BIN_DIR) + "/drape_stability";
const std::string kConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs/";

class StabilityTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more, const ProcessLimits& limits = {}) const {
    std::vector<std::string> command = {kStability,
                                        "--mesh=disc:100",
                                        "--material=" + kConfigs + "fabrics/synthetic_felt.json",
                                        "--start=" + kConfigs + "starts/four_waves.json",
                                        "--damping_time_step=0.1",
                                        "--threads=2",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }
};

TEST_F(StabilityTool, WritesRunsFindingsAndMaps) {
  const ProcessResult result =
      Run({"--maps=step time_step=0.1/0.5 tangle=0/0.1,explicit time_step=1e-3/2e-3 bend=1/2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("largest stable explicit step"));
  EXPECT_GT(ReadImage(Path("out/step-time_step-tangle.png")).width, 500);
  const Json findings = ReadJson(Path("out/findings.json"));
  EXPECT_EQ(findings.at("outcome"), "done");
  EXPECT_EQ(findings.at("runs"), 8);
  EXPECT_EQ(findings.at("counts").at("diverged"), 4);
  const Json map = findings.at("maps").at(0);
  EXPECT_EQ(map.at("rows_up").at(1), Json::array({"settled", "settled"}));
  const Json limit = findings.at("maps").at(1).at("explicit_limits").at(0);
  EXPECT_NEAR(limit.at("measured_s").get<double>() / limit.at("theory_s").get<double>(), 1, 0.08);
  EXPECT_EQ(findings.at("damping").size(), 4u);  // two methods, two modes
  const std::string runs = Read(Path("out/runs.csv"));
  EXPECT_EQ(std::count(runs.begin(), runs.end(), '\n'), 2 + 8);
  EXPECT_THAT(runs, testing::Not(testing::HasSubstr("nan")));
  EXPECT_THAT(runs, testing::Not(testing::HasSubstr("inf")));
}

TEST_F(StabilityTool, CtrlCKeepsTheRunsAndResumeGoesOn) {
  const std::string map = "--maps=step time_step=0.02:0.5:20 stretch=1:2:100";
  constexpr int kLinesBeforeRuns = 2;
  const auto after = [&](int runs) -> ProcessLimits {
    return {.interrupt_when = Path("out/runs.csv"), .interrupt_lines = kLinesBeforeRuns + runs};
  };
  const ProcessResult stopped = Run({map}, after(1));
  ASSERT_EQ(stopped.exit_code, 130) << stopped.err;
  const Json findings = ReadJson(Path("out/findings.json"));
  EXPECT_EQ(findings.at("outcome"), "cancelled");
  const int before = findings.at("runs");
  EXPECT_GT(before, 0);
  EXPECT_LT(before, 2000);
  const ProcessResult again = Run({map, "--resume"}, after(before + 1));
  ASSERT_EQ(again.exit_code, 130) << again.err;
  EXPECT_GT(ReadJson(Path("out/findings.json")).at("runs"), before);
  ExpectOneLineError(Run({map, "--resume", "--drag=1"}), "made with other settings");
}

TEST_F(StabilityTool, MistakesAreOneLineAndLeaveNothing) {
  const std::string map = "--maps=step time_step=0.1/0.5 tangle=0/1";
  ExpectOneLineError(Run({}), "option 'maps'");
  ExpectOneLineError(Run({"--maps=step time_step=0.1/0.5"}), "expected two axes");
  ExpectOneLineError(Run({"--maps=jump time_step=0.1/0.5 bend=1/2"}),
                     "expected one of explicit, step,");
  ExpectOneLineError(Run({map, "--filter=bend"}), "which no map has in its name");
  ExpectOneLineError(Run({map, "--material=" + Path("no.json")}), "no.json");
  ExpectOneLineError(Run({map, "--duration=0"}), "duration");
  ExpectOneLineError(Run({map, "--mesh=disc:100,radius=0.08,support=0.05"}), "support");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(StabilityTool, HelpAndConfigsAreComplete) {
  StabilityOptions options;
  const OptionTable table = StabilityTable(options);
  EXPECT_EQ(RunProcess({kStability, "--help"}).out, table.Help());
  std::size_t cases = 0;
  for (const char* name : {"studies/stability.json", "studies/stability_quick.json"}) {
    table.ReadConfig(kConfigs + name);
    for (const std::string& line : options.maps)
      for (const StabilityMap& map : ParseStabilityMaps(line, name)) cases += map.Cases().size();
  }
  EXPECT_GE(cases, 1500u);
}

}  // namespace
}  // namespace drape::test
  ExpectOneLineError(Run({map, "--base=" + kFabric}), "option 'base'");
