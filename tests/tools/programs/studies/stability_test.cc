// SPDX-License-Identifier: Apache-2.0
// drape_stability as a user runs it.
#include <algorithm>
#include <csignal>
#include <future>
#include <sstream>

#include "losses/image/image.h"
#include "physics/util/stored/csv_log.h"
#include "solver/studies/cells/cell_folder.h"
#include "tests/tools/tool_fixture.h"
#include "tools/programs/studies/stability/stability_tool.h"

namespace drape::test {
namespace {

const std::string kStability = std::string(DRAPE_BIN_DIR) + "/drape_stability";
const std::string kStabilityConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs/";

class StabilityTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more, const ProcessLimits& limits = {}) const {
    std::vector<std::string> command = {
        kStability,
        "--mesh=disc:100",
        "--material=" + kStabilityConfigs + "fabrics/synthetic_felt.json",
        "--start=" + kStabilityConfigs + "starts/four_waves.json",
        "--damping_time_step=0.1",
        "--threads=2",
        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }

  // The rows of a table of runs but for the time that they took.
  std::string WithoutSeconds(const std::string& file) const {
    std::istringstream lines(Read(Path(file)));
    std::string line, text;
    std::getline(lines, text);  // what all runs share
    std::size_t seconds = 0;
    for (int row = 0; std::getline(lines, line); ++row) {
      CsvRow fields = ParseCsvRow(line, file);
      if (row == 0)
        seconds = static_cast<std::size_t>(std::find(fields.begin(), fields.end(), "seconds") -
                                           fields.begin());
      fields.at(seconds).clear();
      text += '\n';
      text += FormatCsvRow(fields);
    }
    return text;
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

// Three shares side by side, one of them killed and repeated, are one run.
TEST_F(StabilityTool, SharesGatherToTheSameRuns) {
  const std::string map = "--maps=step time_step=0.02:0.5:4 bend=1:4:6";
  ASSERT_EQ(Run({map, "--out=" + Path("whole")}).exit_code, 0);
  const ProcessResult list = Run({map, "--list"});
  EXPECT_EQ(std::count(list.out.begin(), list.out.end(), '\n'), 24);
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const std::string own = Run({map, "--list", "--share=1/3"}).out;
  EXPECT_THAT(list.out, testing::HasSubstr(own.substr(0, own.find('\n') + 1)));
  const std::string first = own.substr(0, own.find('\n'));
  const auto share = [&](const std::string& name, const ProcessLimits& limits = {}) {
    return Run({map, "--threads=1", "--share=" + name}, limits);
  };
  const ProcessLimits killed = {.interrupt_when = CellFolder(Path("out/cells"), "").Path(first),
                                .interrupt_signal = SIGKILL};
  auto other = std::async(std::launch::async, [&] { return share("0/3"); });
  auto third = std::async(std::launch::async, [&] { return share("2/3"); });
  EXPECT_EQ(share("1/3", killed).exit_code, 128 + SIGKILL);
  const ProcessResult again = share("1/3");
  EXPECT_THAT(again.out, testing::HasSubstr("share 1/3: 8 of 8 cells are complete"));
  EXPECT_EQ(other.get().exit_code, 0);
  EXPECT_EQ(third.get().exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(Path("out/runs.csv")));
  const auto cells = Snapshot(Path("out/cells"));
  const ProcessResult gathered = Run({map});
  ASSERT_EQ(gathered.exit_code, 0) << gathered.err;
  EXPECT_EQ(Snapshot(Path("out/cells")), cells);
  EXPECT_EQ(WithoutSeconds("out/runs.csv"), WithoutSeconds("whole/runs.csv"));
  EXPECT_EQ(Read(Path("out/step-time_step-bend.png")), Read(Path("whole/step-time_step-bend.png")));
  Json findings = ReadJson(Path("out/findings.json")),
       whole = ReadJson(Path("whole/findings.json"));
  for (const char* key : {"seconds", "provenance"}) {
    findings.erase(key);
    whole.erase(key);
  }
  EXPECT_EQ(findings, whole);
}

TEST_F(StabilityTool, SharesOfOtherSettingsAreNotMixedIn) {
  const std::string map = "--maps=step time_step=0.1/0.5 bend=1/2";
  ASSERT_EQ(Run({map, "--share=0/2"}).exit_code, 0);
  for (const char* share : {"--share=1/2", "--threads=1"})
    ExpectOneLineError(Run({map, "--drag=1", share}), "made with other settings");
  ExpectOneLineError(Run({map, "--share=2/2"}), "option 'share': found '2/2', expected i/n");
}

TEST_F(StabilityTool, MistakesAreOneLineAndLeaveNothing) {
  const std::string map = "--maps=step time_step=0.1/0.5 tangle=0/1";
  ExpectOneLineError(Run({}), "option 'maps'");
  ExpectOneLineError(Run({"--maps=step time_step=0.1/0.5"}), "expected two axes");
  ExpectOneLineError(Run({"--maps=jump time_step=0.1/0.5 bend=1/2"}),
                     "expected one of explicit, step,");
  ExpectOneLineError(Run({map, "--filter=bend"}), "which no map has in its name");
  ExpectOneLineError(Run({map, "--material=" + Path("no.json")}), "no.json");
  ExpectOneLineError(Run({map, "--base=" + kFabric}), "option 'base'");
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
    table.ReadConfig(kStabilityConfigs + name);
    for (const std::string& line : options.maps)
      for (const StabilityMap& map : ParseStabilityMaps(line, name)) cases += map.Cases().size();
  }
  EXPECT_GE(cases, 1500u);
}

}  // namespace
}  // namespace drape::test
