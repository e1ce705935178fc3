// SPDX-License-Identifier: Apache-2.0
// drape_stability as a user runs it.
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <future>
#include <map>

#include "losses/image/image.h"
#include "physics/util/atomic_file.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kStability = std::string(DRAPE_BIN_DIR) + "/drape_stability";
const std::string kStabilityConfigs = std::string(DRAPE_SOURCE_DIR) + "/configs/";

class StabilityTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more, ProcessLimits limits = {}) const {
    limits.charts = charts_;
    std::vector<std::string> command = {
        kStability,
        "--mesh=disc:100",
        "--fabric=" + kStabilityConfigs + "fabrics/synthetic_felt.json",
        "--start=" + kStabilityConfigs + "starts/four_waves.json",
        "--damping_time_step=0.1",
        "--threads=2",
        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }

  // The results of a study but for the time that each took.
  Json WithoutSeconds(const std::string& file) const {
    Json study = ReadJson(Path(file));
    study.erase("provenance");
    for (Json& cell : study.at("cells"))
      if (cell.at("result").is_object()) cell.at("result").erase("seconds");
    return study;
  }
  std::size_t CountCells() const {
    std::size_t count = 0;
    for (const auto& file : std::filesystem::directory_iterator(Path("out/cells")))
      count += file.path().extension() == ".json";
    return count;
  }

  bool charts_ = false;
};

TEST_F(StabilityTool, WritesRunsResultsAndMaps) {
  charts_ = true;
  const ProcessResult result =
      Run({"--maps=step time_step=0.1/0.5 tangle=0/0.1,explicit time_step=1e-3/2e-3 bend=1/2"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("largest stable explicit step"));
  EXPECT_GT(ReadImage(Path("out/step-time_step-tangle.png")).width, 500);
  const Json study = ReadJson(Path("out/stability.json"));
  EXPECT_EQ(study.at("outcome"), "done");
  std::map<std::string, int> outcomes;
  Json limit;
  for (const Json& cell : study.at("cells")) {
    if (cell.at("input").at("kind") == "run") ++outcomes[cell.at("result").at("outcome")];
    if (cell.at("name") == "limit of explicit") limit = cell.at("result");
  }
  EXPECT_EQ(outcomes.at("diverged"), 4);
  EXPECT_EQ(outcomes.at("settled"), 4);
  EXPECT_NEAR(limit.at("measured_s").get<double>() / limit.at("theory_s").get<double>(), 1, 0.08);
  EXPECT_EQ(study.at("cells").size(), 8u + 2u + 4u);  // runs, limits, two methods of two modes
  const std::string runs = Read(Path("out/runs.csv"));
  EXPECT_EQ(std::count(runs.begin(), runs.end(), '\n'), 1 + 8);
  EXPECT_THAT(runs, testing::Not(testing::HasSubstr("nan")));
  EXPECT_THAT(runs, testing::Not(testing::HasSubstr("inf")));
}

TEST_F(StabilityTool, CtrlCKeepsTheRunsAndTheSameCommandGoesOn) {
  const std::string map = "--maps=step time_step=0.02:0.5:20 stretch=1:2:100";
  const std::string own = Run({map, "--list"}).out;
  EXPECT_EQ(std::count(own.begin(), own.end(), '\n'), 2000 + 4);
  const ProcessResult stopped =
      Run({map}, {.interrupt_when = Path("out/cells"), .interrupt_after = 2.0});
  ASSERT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_EQ(ReadJson(Path("out/stability.json")).at("outcome"), "cancelled");
  const std::size_t before = CountCells();
  EXPECT_GT(before, 0u);
  EXPECT_LT(before, 2000u);
  ASSERT_EQ(Run({map}, {.interrupt_when = Path("out/cells"), .interrupt_after = 2.0}).exit_code,
            130);
  EXPECT_GT(CountCells(), before);
}

// Three shares side by side, one of them killed and repeated, are one run.
TEST_F(StabilityTool, SharesGatherToTheSameRuns) {
  const std::string map = "--maps=step time_step=0.02:0.5:4 bend=1:4:6";
  charts_ = true;
  ASSERT_EQ(Run({map, "--out=" + Path("whole")}).exit_code, 0);
  const ProcessResult list = Run({map, "--list"});
  EXPECT_EQ(std::count(list.out.begin(), list.out.end(), '\n'), 24 + 4);
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const std::string own = Run({map, "--list", "--share=1/3"}).out;
  EXPECT_THAT(list.out, testing::HasSubstr(own.substr(0, own.find('\n') + 1)));
  const auto share = [&](const std::string& name, const ProcessLimits& limits = {}) {
    return Run({map, "--threads=1", "--share=" + name}, limits);
  };
  auto other = std::async(std::launch::async, [&] { return share("0/3"); });
  auto third = std::async(std::launch::async, [&] { return share("2/3"); });
  const ProcessLimits killed = {
      .interrupt_when = Path("out/cells"), .interrupt_after = 0.1, .interrupt_signal = SIGKILL};
  EXPECT_EQ(share("1/3", killed).exit_code, 128 + SIGKILL);
  const ProcessResult again = share("1/3");
  EXPECT_THAT(again.out, testing::HasSubstr("share 1/3: 9 of 9 cells are complete"));
  EXPECT_EQ(other.get().exit_code, 0);
  EXPECT_EQ(third.get().exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(Path("out/stability.json")));
  RemoveTemporaries(Path("out/cells"), 1);  // what the killed share was writing
  const auto cells = Snapshot(Path("out/cells"));
  const ProcessResult gathered = Run({map});
  ASSERT_EQ(gathered.exit_code, 0) << gathered.err;
  EXPECT_EQ(Snapshot(Path("out/cells")), cells);
  EXPECT_EQ(WithoutSeconds("out/stability.json"), WithoutSeconds("whole/stability.json"));
  EXPECT_EQ(Read(Path("out/step-time_step-bend.png")), Read(Path("whole/step-time_step-bend.png")));
}

// A finished run belongs to the bytes of the material, not to its path.
TEST_F(StabilityTool, RunsOfAChangedMaterialUnderTheSamePathAreNotMixedIn) {
  const std::string felt = Read(kStabilityConfigs + "fabrics/synthetic_felt.json");
  Json stiffer = Json::parse(felt, nullptr, true, true);
  for (Json& row : stiffer.at("bend"))
    for (Json& entry : row) entry = 30.0 * entry.get<double>();
  const std::string map = "--maps=step time_step=0.1/0.2 stiffness=0.1/1",
                    material = "--fabric=" + Write("m.json", felt);
  ASSERT_EQ(Run({map, material, "--share=0/2"}).exit_code, 0);
  Write("m.json", stiffer.dump());
  ASSERT_EQ(Run({map, material, "--share=1/2"}).exit_code, 0);
  ASSERT_EQ(Run({map, material}).exit_code, 0);
  ASSERT_EQ(Run({map, material, "--out=" + Path("fresh")}).exit_code, 0);
  EXPECT_EQ(WithoutSeconds("out/stability.json"), WithoutSeconds("fresh/stability.json"));
}

TEST_F(StabilityTool, MistakesAreOneLineAndLeaveNothing) {
  const std::string map = "--maps=step time_step=0.1/0.5 tangle=0/1";
  ExpectOneLineError(Run({}), "option 'maps'");
  ExpectOneLineError(Run({"--maps=step time_step=0.1/0.5"}), "expected two axes");
  ExpectOneLineError(Run({"--maps=jump time_step=0.1/0.5 bend=1/2"}),
                     "expected one of explicit, step,");
  ExpectOneLineError(Run({map, "--share=2/2"}), "option 'share': found '2/2', expected i/n");
  ExpectOneLineError(Run({map, "--fabric=" + Path("no.json")}), "no.json");
  ExpectOneLineError(Run({map, "--duration=0"}), "duration");
  ExpectOneLineError(Run({map, "--mesh=disc:100,radius=0.08,support=0.05"}), "support");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(StabilityTool, HelpAndConfigsAreComplete) {
  const std::string help = RunProcess({kStability, "--help"}).out;
  std::ptrdiff_t cells = 0;
  for (const char* name : {"studies/stability.json", "studies/stability_quick.json"}) {
    const std::string config = kStabilityConfigs + name;
    const Json keys = Json::parse(Read(config), nullptr, true, true);
    for (const auto& [key, value] : keys.items())
      EXPECT_THAT(help, testing::HasSubstr("\n  --" + key)) << name;
    const ProcessResult list =
        RunProcess({kStability, "--config=" + config, "--list", "--out=" + Path("out")});
    EXPECT_EQ(list.exit_code, 0) << list.err;
    cells += std::count(list.out.begin(), list.out.end(), '\n');
  }
  EXPECT_GE(cells, 1500);
}

}  // namespace
}  // namespace drape::test
