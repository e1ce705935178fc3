// SPDX-License-Identifier: Apache-2.0
// drape_equilibria: its clusters and spread by hand-made samples, its files from the real program.
#include <cmath>

#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "solver/forward/random_drapes.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

using testing::ElementsAre;

const std::string kFindEquilibria = std::string(DRAPE_BIN_DIR) + "/drape_equilibria";

// A drape at rest with `folds` folds turned by `turn`, of the given energy.
DrapeSample FoldedSample(int seed, int folds, double turn, double energy) {
  static const Mesh mesh = MakeDisc({.target_vertices = 200});
  DrapeSample sample;
  sample.seed = seed;
  sample.at_rest = sample.stable = true;
  sample.energy = energy;
  sample.residual = 1e-10 * seed;
  sample.outline.resize(kBranchAngles);
  for (int i = 0; i < kBranchAngles; ++i)
    sample.outline[i] = .11 + .01 * std::cos(folds * (2 * M_PI * i / kBranchAngles - turn));
  sample.x = FlapsFromOutline(mesh, .09, sample.outline, 1.0);
  sample.signature = ComputeSignature(sample.outline, {});
  sample.silhouette = GrayImage(256, 256, folds == 6 ? 0.25f : 0.75f);
  return sample;
}

std::vector<DrapeSample> HandMade() {
  const double turn = 2 * M_PI * 20 / kBranchAngles;
  std::vector<DrapeSample> samples = {FoldedSample(1, 6, 0, -2.0), FoldedSample(2, 7, 0, -1.0),
                                      FoldedSample(3, 7, turn, -3.0), FoldedSample(4, 7, 0, -1.5),
                                      FoldedSample(5, 7, 0, -9.0)};
  samples[4].at_rest = samples[4].stable = false;
  samples[2].stable = false;
  return samples;
}

TEST(Branches, ClusterByTheDistanceAskedFor) {
  const auto samples = HandMade();
  const auto fixed = ClusterSamples(samples, BranchMetric::kVertices, 1e-4);
  ASSERT_EQ(fixed.size(), 3u);
  EXPECT_THAT(fixed[0].members, ElementsAre(3, 1));  // the lower energy first
  EXPECT_THAT(fixed[1].members, ElementsAre(2));     // alone: by energy
  EXPECT_THAT(fixed[2].members, ElementsAre(0));
  EXPECT_DOUBLE_EQ(fixed[0].frequency, 0.5);
  EXPECT_DOUBLE_EQ(fixed[0].residual, 4e-10);
  EXPECT_TRUE(fixed[0].stable);
  EXPECT_FALSE(fixed[1].stable);
  EXPECT_EQ(ClusterSamples(samples, BranchMetric::kOutline, 1e-4).size(), 3u);
  const auto turned = ClusterSamples(samples, BranchMetric::kRotated, 1e-4);
  ASSERT_EQ(turned.size(), 2u);
  EXPECT_THAT(turned[0].members, ElementsAre(2, 3, 1));
  EXPECT_EQ(ClusterSamples(samples, BranchMetric::kMirrored, 1e-4).size(), 2u);
}

TEST(Branches, SpreadIsOverTheDrapesAtRestAndTheirPairs) {
  const BranchSpread spread = ComputeSpread(HandMade());
  EXPECT_EQ(spread.drapes, 4);
  EXPECT_DOUBLE_EQ(spread.folds.mean, 6.75);
  EXPECT_DOUBLE_EQ(spread.folds.sd, 0.5);
  EXPECT_NEAR(spread.silhouette_mse.mean, 0.5 * 0.25, 1e-12);  // 3 of 6 pairs differ by 0.5
  EXPECT_NEAR(spread.silhouette_mse.sd, std::sqrt(6 * 0.125 * 0.125 / 5), 1e-12);
  EXPECT_LT(spread.drape_coefficient.sd, 1e-12);
  EXPECT_GT(spread.outline_rms.mean, 5e-3);
  EXPECT_EQ(ComputeSpread({}).drapes, 0);
  EXPECT_EQ(ComputeSpread({FoldedSample(1, 6, 0, 0)}).folds.sd, 0.0);
}

class EquilibriaTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more, const ProcessLimits& limits = {}) const {
    std::vector<std::string> command = {kFindEquilibria,       "--mesh=disc:120",     "--samples=4",
                                        "--steps=60",          "--fabric=" + kFabric, "--threads=2",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }
};

TEST_F(EquilibriaTool, WritesTableStatesAndOutlines) {
  const ProcessResult result = Run({});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::HasSubstr("energy [mJ]"));
  EXPECT_THAT(result.out, testing::HasSubstr("drape coefficient"));
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("outcome"), "done");
  ASSERT_EQ(summary.at("samples").size(), 4u);
  EXPECT_EQ(summary.at("samples").at(2).at("seed"), 3);
  const Json& branches = summary.at("branches");
  EXPECT_THAT(result.out, testing::HasSubstr(std::to_string(summary.at("at_rest").get<int>()) +
                                             " drapes at rest, " + std::to_string(branches.size()) +
                                             " branch"));
  double share = 0.0;
  for (const Json& branch : branches) share += branch.at("frequency").get<double>();
  EXPECT_NEAR(share, 1.0, 1e-12);
  EXPECT_LT(summary.at("branches").at(0).at("energy_J"), 0.0);
  // Branch by branch, each with its own drapes.
  const Json outlines = ReadJson(Path("out/outlines.json")).at("drapes");
  ASSERT_EQ(outlines.size(), summary.at("at_rest"));
  size_t next = 0;
  for (size_t b = 0; b < branches.size(); ++b)
    for (const Json& seed : branches[b].at("seeds")) {
      const Json& outline = outlines.at(next++);
      EXPECT_EQ(outline.at("group"), b);
      EXPECT_EQ(outline.at("name"), "branch " + std::to_string(b + 1) + ", seed " + seed.dump());
      const Json& sample = summary.at("samples").at(seed.get<size_t>() - 1);
      EXPECT_EQ(outline.at("folds"), sample.at("folds"));
      EXPECT_EQ(outline.at("dc"), sample.at("dc"));
    }
}

TEST_F(EquilibriaTool, SaysHowManyBranchesAreLeftOut) {
  const ProcessResult each = Run({"--samples=16", "--tolerance=1e-12"});
  ASSERT_EQ(each.exit_code, 0) << each.err;
  const std::size_t count = ReadJson(Path("out/summary.json")).at("branches").size();
  ASSERT_GT(count, 10u);
  EXPECT_THAT(each.out,
              testing::HasSubstr("… " + std::to_string(count - 10) + " more in summary.json\n"));
  EXPECT_THAT(each.out,
              testing::HasSubstr(std::to_string(count) + " branches: hardly any two starts"));
  EXPECT_THAT(Run({"--tolerance=1"}).out, testing::HasSubstr(" drapes at rest, 1 branch\n"));
}

TEST_F(EquilibriaTool, ItsStatesAreDrapesAtRest) {
  ASSERT_EQ(Run({}).exit_code, 0);
  const Json branch = ReadJson(Path("out/summary.json")).at("branches").at(0);
  ASSERT_EQ(Simulate({"--solve=static", "--start=" + Path("out/branch_1.json"),
                      "--out=" + Path("replay")})
                .exit_code,
            0);
  const Json replay = ReadJson(Path("replay/summary.json"));
  EXPECT_EQ(replay.at("newton_iterations"), 0);
  EXPECT_EQ(replay.at("folds"), branch.at("folds"));
  EXPECT_NEAR(replay.at("dc").get<double>(), branch.at("dc").get<double>(), 5e-3);
}

TEST_F(EquilibriaTool, DoesNotDependOnTheThreads) {
  ASSERT_EQ(Run({}).exit_code, 0);
  ASSERT_EQ(Run({"--threads=1", "--out=" + Path("one")}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/branch_1.json")), Read(Path("one/branch_1.json")));
  EXPECT_EQ(Read(Path("out/outlines.json")), Read(Path("one/outlines.json")));
}

TEST_F(EquilibriaTool, CtrlCWritesWhatThereIs) {
  const ProcessResult stopped =
      Run({"--samples=1000"}, {.interrupt_when = Path("out"), .interrupt_after = 2.0});
  ASSERT_EQ(stopped.exit_code, 130) << stopped.err;
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("outcome"), "cancelled");
  EXPECT_LT(summary.at("samples").size(), 1000u);
  EXPECT_EQ(ReadJson(Path("out/outlines.json")).at("drapes").size(), summary.at("at_rest"));
}

TEST_F(EquilibriaTool, MistakesAreOneLine) {
  ExpectOneLineError(Run({"--samples=0"}), "expected a whole number, 1 … 1000");
  ExpectOneLineError(Run({"--distance=near"}), "expected one of vertices, outline");
  ExpectOneLineError(Run({"--start=flat"}), "unknown option '--start'");
  ExpectOneLineError(Run({"--fabric=" + Path("no.json")}), "no.json");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
}

TEST_F(EquilibriaTool, HelpAndConfigAreComplete) {
  EXPECT_THAT(RunProcess({kFindEquilibria, "--help"}).out,
              testing::HasSubstr("usage: drape_equilibria [--config=FILE]"));
  const std::string config = std::string(DRAPE_SOURCE_DIR) + "/configs/programs/equilibria.json";
  // The config has been read when the command line is.
  ExpectOneLineError(RunProcess({kFindEquilibria, "--config=" + config, "--samples=0"}),
                     "option 'samples': found '0'");
}

}  // namespace
}  // namespace drape::test
