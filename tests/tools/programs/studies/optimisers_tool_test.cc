// SPDX-License-Identifier: Apache-2.0
// drape_compare_optimisers as a user runs it.
#include "solver/studies/optimisers/optimiser_study.h"
#include "tests/tools/tool_fixture.h"

namespace drape::test {
namespace {

const std::string kOptimisers = std::string(DRAPE_BIN_DIR) + "/drape_compare_optimisers";

TEST(Optimisers, PublishedRatesAreThoseOfTheTables) {
  MaterialField material;
  material.stretch.resize(1);
  material.bend.resize(1);
  for (auto& row : material.stretch[0].c)
    for (double& entry : row) entry = 100.0;
  for (auto& row : material.bend[0].b)
    for (double& entry : row) entry = 3e-5;
  const Eigen::VectorXd rates = PublishedAdamRates(material, TyingMatrix(ParameterTying::kColumns));
  ASSERT_EQ(rates.size(), 7);
  EXPECT_NEAR(rates[0], 1e-16, 1e-25);
  EXPECT_NEAR(rates[6], 0.1, 1e-12);
}

class OptimisersTool : public ToolFixture {
 protected:
  ProcessResult Run(const std::vector<std::string>& more, ProcessLimits limits = {}) const {
    limits.charts = charts_;
    const std::string fabrics = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/";
    std::vector<std::string> command = {kOptimisers,
                                        "--twins=" + fabrics + "synthetic_wool.json",
                                        "--fabric=" + fabrics + "synthetic_shirt.json",
                                        "--twin_mesh=disc:120",
                                        "--mesh=disc:100",
                                        "--coarse_mesh=disc:100",
                                        "--num_parameters=2",
                                        "--methods=lm,adam_0.1",
                                        "--budget=12",
                                        "--out=" + Path("out")};
    command.insert(command.end(), more.begin(), more.end());
    return RunProcess(command, limits);
  }

  // The results of compare_optimisers.json by the names of their cells.
  static Json Results(const Json& study) {
    Json results;
    for (const Json& cell : study.at("cells"))
      results[cell.at("name").get<std::string>()] = cell.at("result");
    return results;
  }

  bool charts_ = false;
};

TEST_F(OptimisersTool, WritesTablesAndContinuesFromFinishedRuns) {
  charts_ = true;
  const ProcessResult first = Run({});
  charts_ = false;
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, testing::HasSubstr("\nlm "));
  const Json study = ReadJson(Path("out/compare_optimisers.json"));
  EXPECT_EQ(study.at("outcome"), "done");
  const Json results = Results(study);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_LT(results.at("synthetic_wool_1_2.lm").at("spent"), 14.0);
  for (const auto& run : results) {
    EXPECT_GT(run.at("coupling"), 0.0);
    EXPECT_LT(run.at("coupling"), 0.99);
  }
  for (const char* file :
       {"report.md", "traces.csv", "convergence.svg", "profiles.png", "branches.png"})
    EXPECT_TRUE(std::filesystem::exists(Path(std::string("out/") + file))) << file;
  ASSERT_EQ(Run({}).exit_code, 0);  // CPU seconds would differ if anything ran again
  EXPECT_EQ(Results(ReadJson(Path("out/compare_optimisers.json"))), results);
  ASSERT_EQ(Run({"--budget=13"}).exit_code, 0);  // other cells, beside the first
  EXPECT_GT(Results(ReadJson(Path("out/compare_optimisers.json")))
                .at("synthetic_wool_1_2.lm")
                .at("spent"),
            results.at("synthetic_wool_1_2.lm").at("spent"));
}

TEST_F(OptimisersTool, SharesHaveTheirOwnRunsAndNoTables) {
  const ProcessResult list = Run({"--list"});
  EXPECT_EQ(list.out, "synthetic_wool_1_2.lm\nsynthetic_wool_1_2.adam_0.1\n");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const ProcessResult share = Run({"--share=1/2"});
  ASSERT_EQ(share.exit_code, 0) << share.err;
  EXPECT_THAT(share.out, testing::HasSubstr("share 1/2: 1 of 1 cells are complete"));
  EXPECT_FALSE(std::filesystem::exists(Path("out/compare_optimisers.json")));
}

// What would end the study is found before a silhouette is drawn.
TEST_F(OptimisersTool, RefusesWithoutAnythingWritten) {
  charts_ = true;  // with the Python path of this test
  std::filesystem::create_directories(Path("without_scipy"));
  std::ofstream(Path("without_scipy/scipy.py")) << "import missing_module\n";
  const std::string longest = Path(std::string(245, 'L') + ".json");
  std::filesystem::copy(std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/synthetic_wool.json",
                        longest);
  for (const auto& [option, said] :
       {std::pair<std::string, const char*>{"--twins=" + longest, "name"},
        {"--methods=lm,bo", "expected numpy and scipy"}}) {
    const ProcessResult refused =
        Run({option}, {.environment = {{"PYTHONPATH", Path("without_scipy")}}});
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, testing::HasSubstr(said));
    EXPECT_FALSE(std::filesystem::exists(Path("out"))) << option;
  }
  std::filesystem::create_directories(Path("out/runs.csv"));
  EXPECT_THAT(Run({}).err, testing::HasSubstr("runs.csv: is a folder"));
  EXPECT_FALSE(std::filesystem::exists(Path("out/twins")));
}

TEST_F(OptimisersTool, SeedsMayBeAddedAndDoNotDependOnThreads) {
  const std::vector<std::string> methods = {"--methods=lm,cmaes,hesbo_2,hesbo_2_lm",
                                            "--checkpoints=6", "--threads=2"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), methods.begin(), methods.end());
    return more;
  };
  const std::string name = "synthetic_wool_1_2.hesbo_2.seed";
  ASSERT_EQ(Run(with({"--num_seeds=1"})).exit_code, 0);
  const Json one = Results(ReadJson(Path("out/compare_optimisers.json")));
  ASSERT_EQ(one.size(), 4u);
  ASSERT_EQ(Run(with({"--num_seeds=2", "--threads=1"})).exit_code, 0);
  const Json two = Results(ReadJson(Path("out/compare_optimisers.json")));
  ASSERT_EQ(two.size(), 7u);
  for (const auto& [cell, result] : one.items()) EXPECT_EQ(two.at(cell), result) << cell;
  EXPECT_NE(two.at(name + "1").at("theta"), two.at(name + "2").at("theta"));
  std::filesystem::remove_all(Path("out/cells"));
  ASSERT_EQ(Run(with({"--num_seeds=2"})).exit_code, 0);
  const Json again = Results(ReadJson(Path("out/compare_optimisers.json")));
  for (const auto& [cell, result] : two.items())
    EXPECT_EQ(again.at(cell).at("theta"), result.at("theta")) << cell;
}

TEST_F(OptimisersTool, BadInputIsOneLine) {
  ExpectOneLineError(Run({"--methods=lm,lm"}), "names one twice");
  ExpectOneLineError(Run({"--methods=lm_lm"}), "unknown name 'lm_lm'");
  ExpectOneLineError(Run({"--num_seeds=0"}), "num_seeds");

  ExpectOneLineError(Run({"--methods=newton"}), "unknown name 'newton'");
  ExpectOneLineError(Run({"--num_parameters=4"}), "4");
  ExpectOneLineError(Run({"--budget=0"}), "budget");
  ExpectOneLineError(Run({"--backend=gpu"}), "backend");
  ExpectOneLineError(Run({"--share=1"}), "expected i/n");
  ExpectOneLineError(Run({"--images=" + Path("none.png"), "--image_fabrics=" + kFabric}),
                     "matches nothing");
  ExpectOneLineError(RunProcess({kOptimisers, "--out=" + Path("out")}),
                     "expected at least one problem");
  EXPECT_FALSE(std::filesystem::exists(Path("out/compare_optimisers.json")));
}

TEST_F(OptimisersTool, CtrlCKeepsTheRunsThatAreDone) {
  ASSERT_EQ(Run({"--methods=lm", "--budget=500"}).exit_code, 0);
  const std::string done = Path("out/twins/synthetic_wool_1.png");
  std::filesystem::remove(done);
  const ProcessResult stopped =
      Run({"--methods=lm,adam_0.03,adam_0.1,lbfgs", "--budget=500"}, {.interrupt_when = done});
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  const Json study = ReadJson(Path("out/compare_optimisers.json"));
  EXPECT_EQ(study.at("outcome"), "cancelled");
  EXPECT_TRUE(Results(study).at("synthetic_wool_1_2.lm").is_object());
}

}  // namespace
}  // namespace drape::test
