// SPDX-License-Identifier: Apache-2.0
// drape_compare_optimisers: scores by made-up traces, its files from the real program.
#include <cmath>
#include <limits>

#include "solver/studies/optimisers/optimiser_problem.h"
#include "tests/tools/tool_fixture.h"
#include "tools/programs/studies/optimisers/optimisers_report.h"

namespace drape::test {
namespace {

const std::string kOptimisers = std::string(DRAPE_BIN_DIR) + "/drape_compare_optimisers";

BenchmarkRecord MadeUp(const std::string& problem, const std::string& method,
                       std::vector<TracePoint> trace, double at) {
  BenchmarkRecord record;
  record.problem = problem;
  record.run.method = method;
  record.run.cost = trace.back().cost;
  record.run.trace = std::move(trace);
  record.run.evaluations = 8;
  record.run.failed = 2;
  record.shape = Eigen::VectorXd::Constant(6, at);
  return record;
}

// Costs 100 → 10 and 100 → 19 (within a tenth) on a, 50 → 40 and 50 → 20 on b, on other branches.
OptimiserBenchmark MadeUpBenchmark() {
  OptimiserBenchmark benchmark;
  benchmark.methods = {"quick", "slow"};
  benchmark.problems = {"a", "b"};
  benchmark.runs = {{MadeUp("a", "quick", {{1, 0.1, 100}, {4, 0.4, 10}}, 0.0)},
                    {MadeUp("a", "slow", {{1, 0.2, 100}, {8, 1.2, 19}}, 1e-4)},
                    {MadeUp("b", "quick", {{1, 0.1, 50}, {6, 0.7, 40}}, 0.0)},
                    {MadeUp("b", "slow", {{1, 0.2, 50}, {9, 1.8, 20}}, 0.1)}};
  return benchmark;
}

// One problem, 100 → 10 by a method without seeds; two seeds of another end at 11 and 60.
OptimiserBenchmark MadeUpSeeds() {
  OptimiserBenchmark benchmark;
  benchmark.methods = {"lm", "bo"};
  benchmark.problems = {"a"};
  benchmark.runs = {{MadeUp("a", "lm", {{1, 0.1, 100}, {4, 0.4, 10}}, 0.0)},
                    {MadeUp("a", "bo", {{1, 0.1, 100}, {7, 1.0, 60}, {9, 1.5, 11}}, 0.0),
                     MadeUp("a", "bo", {{1, 0.1, 100}, {8, 1.2, 60}}, 0.0)}};
  for (BenchmarkRecord& record : benchmark.runs[1]) {
    record.run.seconds = 2.0;
    record.run.function_seconds = 0.5;
  }
  return benchmark;
}

TEST(Optimisers, SeedsAreRunsOfTheirOwn) {
  const OptimiserBenchmark benchmark = MadeUpSeeds();
  ASSERT_EQ(benchmark.num_seeds(), 2);
  const std::vector<MethodScore> scores = ScoreMethods(benchmark, 1e-3);
  EXPECT_DOUBLE_EQ(scores[0].solved_loose, 1.0);
  EXPECT_DOUBLE_EQ(scores[1].solved_loose, 0.5);
  EXPECT_DOUBLE_EQ(scores[1].failed, 0.25);
  const double first = 1.0 / 90.0, second = 50.0 / 90.0;
  EXPECT_NEAR(scores[1].gap.median, 0.5 * (first + second), 1e-14);
  EXPECT_NEAR(scores[1].gap.low, 0.75 * first + 0.25 * second, 1e-14);
  EXPECT_NEAR(scores[1].gap.high, 0.25 * first + 0.75 * second, 1e-14);
  EXPECT_DOUBLE_EQ(scores[1].median_own_seconds, 1.5);
  EXPECT_NEAR(GapsAt(benchmark, 1, 8.0).low, second, 1e-14);
  const Eigen::MatrixXd reached = SpentToReachLm(benchmark);
  ASSERT_EQ(reached.rows(), 2);
  EXPECT_EQ(reached(0, 0), 4);
  EXPECT_EQ(reached(1, 0), 4);
  EXPECT_EQ(reached(0, 1), 9);  // 11 = 1.1 · 10
  EXPECT_TRUE(std::isinf(reached(1, 1)));
  EXPECT_EQ(SpentToReachLm(MadeUpBenchmark()).size(), 0);
}

TEST(Optimisers, ProblemsAreSelectedByTheirNumbers) {
  OptimiserBenchmark benchmark = MadeUpBenchmark();
  for (const int run : {2, 3}) benchmark.runs[run].front().parameters = 7;
  const OptimiserBenchmark selected = SelectProblems(benchmark, 7);
  EXPECT_EQ(selected.problems, std::vector<std::string>{"b"});
  EXPECT_EQ(selected.methods, benchmark.methods);
  EXPECT_EQ(selected.Record(0, 1, 0).run.cost, 20);
  EXPECT_TRUE(SelectProblems(benchmark, 39).problems.empty());
}

TEST(Optimisers, QuartilesInterpolateAndKeepInfinity) {
  const double never = std::numeric_limits<double>::infinity();
  const Quartiles five = ComputeQuartiles({5, 1, 4, 2, 3});
  EXPECT_EQ(five.low, 2);
  EXPECT_EQ(five.median, 3);
  EXPECT_EQ(five.high, 4);
  EXPECT_DOUBLE_EQ(ComputeQuartiles({1, 2}).low, 1.25);
  EXPECT_EQ(ComputeQuartiles({1, 2, 3, never, never}).median, 3);
  EXPECT_EQ(ComputeQuartiles({1, 2, 3, never, never}).high, never);
  EXPECT_EQ(ComputeQuartiles({never, never}).low, never);
}

TEST(Optimisers, ScoresOfMadeUpTraces) {
  const std::vector<MethodScore> scores = ScoreMethods(MadeUpBenchmark(), 1e-3);
  EXPECT_DOUBLE_EQ(scores[0].solved_loose, 0.5);
  EXPECT_DOUBLE_EQ(scores[1].solved_loose, 1.0);
  EXPECT_DOUBLE_EQ(scores[1].solved_tight, 0.5);
  EXPECT_DOUBLE_EQ(scores[0].wins, 0.5);
  EXPECT_DOUBLE_EQ(scores[0].best_branch, 0.5);
  EXPECT_DOUBLE_EQ(scores[1].best_branch, 1.0);
  EXPECT_DOUBLE_EQ(scores[0].gap.median, 0.5 * (0.0 + 20.0 / 30.0));
  EXPECT_DOUBLE_EQ(scores[0].failed, 0.25);
  const Eigen::MatrixXd spent = SpentToSolve(MadeUpBenchmark(), 0.1, BudgetUnit::kBudget);
  EXPECT_EQ(spent(0, 0), 4);
  EXPECT_EQ(spent(0, 1), 8);
  EXPECT_FALSE(std::isfinite(spent(1, 0)));
}

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
  ProcessResult Run(const std::vector<std::string>& more, const ProcessLimits& limits = {}) const {
    const std::string fabrics = std::string(DRAPE_SOURCE_DIR) + "/configs/fabrics/";
    std::vector<std::string> command = {kOptimisers,
                                        "--twins=" + fabrics + "synthetic_wool.json",
                                        "--material=" + fabrics + "synthetic_shirt.json",
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
};

TEST_F(OptimisersTool, WritesTablesAndGoesOnFromTheRunsThatAreDone) {
  const ProcessResult first = Run({});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, testing::HasSubstr("\nlm "));
  const Json summary = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(summary.at("outcome"), "done");
  ASSERT_EQ(summary.at("runs").size(), 2u);
  EXPECT_LT(summary.at("runs").at(0).at("spent"), 14.0);
  for (const auto& run : summary.at("runs")) {
    EXPECT_GT(run.at("coupling"), 0.0);
    EXPECT_LT(run.at("coupling"), 0.99);
  }
  for (const char* file :
       {"report.md", "traces.csv", "convergence.png", "profiles.png", "branches.png"})
    EXPECT_TRUE(std::filesystem::exists(Path(std::string("out/") + file))) << file;
  const std::string kept = Read(Path("out/runs/synthetic_wool_1_2.lm.json"));
  std::filesystem::remove(Path("out/runs/synthetic_wool_1_2.adam_0.1.json"));
  ASSERT_EQ(Run({}).exit_code, 0);
  EXPECT_EQ(Read(Path("out/runs/synthetic_wool_1_2.lm.json")), kept);
  const Json again = ReadJson(Path("out/summary.json"));
  EXPECT_EQ(again.at("runs").at(1).at("cost"), summary.at("runs").at(1).at("cost"));
  ExpectOneLineError(Run({"--budget=13"}), "other settings");
}

TEST_F(OptimisersTool, SharesHaveTheirOwnRunsAndNoTables) {
  const ProcessResult list = Run({"--list"});
  EXPECT_EQ(list.out, "synthetic_wool_1_2.lm\nsynthetic_wool_1_2.adam_0.1\n");
  EXPECT_FALSE(std::filesystem::exists(Path("out")));
  const ProcessResult share = Run({"--share=1/2"});
  ASSERT_EQ(share.exit_code, 0) << share.err;
  EXPECT_THAT(share.out, testing::HasSubstr("share 1/2: 1 of 1 cells are complete"));
  EXPECT_TRUE(std::filesystem::exists(Path("out/runs/synthetic_wool_1_2.adam_0.1.json")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/runs/synthetic_wool_1_2.lm.json")));
  EXPECT_FALSE(std::filesystem::exists(Path("out/summary.json")));
}

TEST_F(OptimisersTool, SeedsMayBeAddedAndDoNotDependOnThreads) {
  const std::vector<std::string> methods = {"--methods=lm,cmaes,hesbo_2,hesbo_2_lm",
                                            "--checkpoints=6", "--threads=2"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), methods.begin(), methods.end());
    return more;
  };
  ASSERT_EQ(Run(with({"--num_seeds=2"})).exit_code, 0);
  const Json summary = ReadJson(Path("out/summary.json"));
  ASSERT_EQ(summary.at("runs").size(), 7u);
  EXPECT_EQ(summary.at("methods").at(2).at("gaps").size(), 2u);
  EXPECT_TRUE(std::filesystem::exists(Path("out/data_profiles.png")));
  EXPECT_TRUE(std::filesystem::exists(Path("out/quartiles.png")));
  const std::string file = Path("out/runs/synthetic_wool_1_2.hesbo_2_lm.seed2.json");
  ASSERT_TRUE(std::filesystem::exists(file));
  const std::string kept = Read(Path("out/runs/synthetic_wool_1_2.hesbo_2_lm.seed1.json"));
  std::filesystem::remove(file);
  ASSERT_EQ(Run(with({"--num_seeds=3", "--threads=1"})).exit_code, 0);
  EXPECT_EQ(Read(Path("out/runs/synthetic_wool_1_2.hesbo_2_lm.seed1.json")), kept);
  const Json again = ReadJson(Path("out/summary.json"));
  ASSERT_EQ(again.at("runs").size(), 10u);
  EXPECT_EQ(again.at("runs").at(8).at("cost"), summary.at("runs").at(6).at("cost"));
  EXPECT_EQ(again.at("runs").at(8).at("seed"), 2);
  EXPECT_NE(again.at("runs").at(1).at("cost"), again.at("runs").at(2).at("cost"));
}

TEST_F(OptimisersTool, BadInputIsOneLine) {
  ExpectOneLineError(Run({"--methods=lm,lm"}), "names one twice");
  ExpectOneLineError(Run({"--methods=lm_lm"}), "unknown name 'lm_lm'");
  ExpectOneLineError(Run({"--num_seeds=0"}), "num_seeds");

  ExpectOneLineError(Run({"--methods=newton"}), "unknown name 'newton'");
  ExpectOneLineError(Run({"--num_parameters=4"}), "4");
  ExpectOneLineError(Run({"--budget=0"}), "budget");
  ExpectOneLineError(Run({"--base=" + kFabric}), "option 'base'");
  ExpectOneLineError(Run({"--backend=gpu"}), "backend");
  ExpectOneLineError(Run({"--share=1"}), "expected i/n");
  ExpectOneLineError(Run({"--images=" + Path("none.png"), "--image_materials=" + kFabric}),
                     "matches nothing");
  ExpectOneLineError(RunProcess({kOptimisers, "--out=" + Path("out")}),
                     "expected at least one problem");
  EXPECT_FALSE(std::filesystem::exists(Path("out/summary.json")));
}

TEST_F(OptimisersTool, CtrlCKeepsTheRunsThatAreDone) {
  const std::string done = Path("out/runs/synthetic_wool_1_2.lm.json");
  const ProcessResult stopped =
      Run({"--methods=lm,adam_0.03,adam_0.1,lbfgs", "--budget=500"}, {.interrupt_when = done});
  EXPECT_EQ(stopped.exit_code, 130) << stopped.err;
  EXPECT_TRUE(std::filesystem::exists(done));
}

}  // namespace
}  // namespace drape::test
