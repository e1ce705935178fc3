// SPDX-License-Identifier: Apache-2.0
// The plan of drape_bench, and what its runs are compared with.
#include <unistd.h>

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "physics/simulation/backend.h"
#include "physics/util/child_process.h"
#include "physics/util/errors.h"
#include "solver/studies/bench/bench_drape.h"
#include "solver/studies/bench/work_precision.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape::test {
namespace {

BenchAxes TwoByTwo() {
  BenchAxes axes;
  axes.material = {"fabrics/wool.json"};
  axes.mesh = {"disc:300", "disc:600"};
  axes.h = {0.2, 0.1};
  axes.mode = {"adjoint", "tangent"};
  return axes;
}

TEST(Extrapolate, IsExactForItsOrder) {
  const auto quantity = [](double size, double order) {
    return Eigen::Vector2d(3 + 2 * std::pow(size, order), 5 - std::pow(size, order)).eval();
  };
  for (const double order : {1.0, 2.0, 3.0}) {
    const Eigen::Vector2d limit =
        Extrapolate<Eigen::Vector2d>(quantity(0.1, order), quantity(0.15, order), 1.5, order);
    EXPECT_LT((limit - Eigen::Vector2d(3, 5)).norm(), 1e-12) << order;
  }
}

TEST(BenchPlan, IsTheProductOfTheAxesThatTheWorkHas) {
  const auto forward = ListRuns(BenchWork::kForward, TwoByTwo());
  ASSERT_EQ(forward.size(), 4u);
  EXPECT_EQ(forward[0].mesh, "disc:300");
  EXPECT_EQ(forward[0].h, 0.2);
  EXPECT_EQ(forward[1].h, 0.1);
  EXPECT_EQ(forward[1].steps(), 100);
  EXPECT_EQ(forward[2].mesh, "disc:600");
  EXPECT_EQ(ListRuns(BenchWork::kGradient, TwoByTwo()).size(), 8u);
}

TEST(BenchPlan, OnlyDistributionsHaveDraws) {
  BenchAxes axes = TwoByTwo();
  axes.mesh.resize(1);
  axes.h.resize(1);
  axes.mode.resize(1);
  axes.model = {"homogeneous", "bdp"};
  axes.draws = {8, 16};
  const auto runs = ListRuns(BenchWork::kFit, axes);
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_FALSE(ListAxes(runs[0]).contains("draws"));
  EXPECT_EQ(ListAxes(runs[2]).at("draws"), 16);
}

TEST(BenchPlan, OneThreadHasNoBatches) {
  BenchAxes axes = TwoByTwo();
  axes.mesh.resize(1);
  axes.h.resize(1);
  axes.backend = {"cpu", "cuda"};
  axes.batch = {1, 64};
  EXPECT_EQ(ListRuns(BenchWork::kForward, axes).size(), 3u);
  axes.threads = {2};
  EXPECT_EQ(ListRuns(BenchWork::kForward, axes).size(), 4u);
}

TEST(BenchPlan, NamesEachRunByItsOwnSettings) {
  const auto runs = ListRuns(BenchWork::kGradient, TwoByTwo());
  std::set<std::string> names;
  for (const BenchSetting& run : runs) names.insert(RunName(BenchWork::kGradient, run));
  EXPECT_EQ(names.size(), runs.size());
  EXPECT_NE(RunName(BenchWork::kForward, runs[0]), RunName(BenchWork::kGradient, runs[0]));
  EXPECT_EQ(RunName(BenchWork::kGradient, runs[1]),
            "gradient material=wool mesh=disc:300 time_step=0.2 mode=tangent");
  BenchSetting run;
  run.material = "a/wool.json#felt";
  run.mesh = "a/disc.obj";
  EXPECT_EQ(RunName(BenchWork::kForward, run), "forward material=wool#felt mesh=disc.obj");
}

TEST(BenchPlan, RefusesTwoRunsOfOneName) {
  BenchAxes axes = TwoByTwo();
  axes.h = {0.1, 0.1};
  EXPECT_INPUT_ERROR(ListRuns(BenchWork::kForward, axes),
                     "axes: found two runs 'forward material=wool mesh=disc:300', expected "
                     "different values");
  axes = TwoByTwo();
  axes.material = {"a/wool.json", "b/wool.json"};
  EXPECT_INPUT_ERROR(ListRuns(BenchWork::kForward, axes), "whose files have different names");
  EXPECT_INPUT_ERROR(ParseName<BenchWork>("backward", "option 'work'"), "found 'backward'");
}

TEST(BenchReference, TheSecondMeshIsTheFiner) {
  CheckReference({.fine = "disc:200", .coarse = "disc:100"});
  EXPECT_INPUT_ERROR(CheckReference({.fine = "disc:100", .coarse = "disc:100"}),
                     "option 'reference': found disc:100 after disc:100, expected a finer mesh");
}

// Threads of the parent do not survive the fork; the child would wait for them forever.
TEST(RunInChild, RunsBatchesInParallelAfterItsParentDid) {
#ifdef __clang__
  GTEST_SKIP() << "a child of a program with LLVM's OpenMP waits for its parent's threads";
#endif
  const auto model = SmallDisc("smooth", 100);
  const MaterialField material = TestMaterial();
  const State start = model->RestState();
  const std::vector<RolloutInput> batch(8, {&material, &start});
  const auto run = [&] {
    MakeCpuBackend(model, 2)->Rollouts(batch, {.h = 0.1, .steps = 2}, nullptr);
    return std::string("done");
  };
  run();
  std::atomic<bool> cancel = false;
  std::jthread watch([&](const std::stop_token& stop) {
    for (int i = 0; i < 300 && !stop.stop_requested(); ++i) usleep(100000);
    cancel = true;
  });
  EXPECT_EQ(RunInChild(run, &cancel).output, "done");
}

}  // namespace
}  // namespace drape::test
