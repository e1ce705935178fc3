// SPDX-License-Identifier: Apache-2.0
// The staged protocol on a small stiff cloth, whose few branches the seeds find.
#include "solver/staged_fit.h"

#include <gmock/gmock.h>

#include <cmath>

#include "solver/spectrum.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr double kTrueBend = 5.0;  // times the start tables

class StagedFitTest : public testing::Test {
 protected:
  StagedFitTest() {
    options_.grid.stretch = {1.0};
    options_.grid.bend = {3.0, 8.0};
    options_.grid.lifts = {0.6, 1.0};
    options_.grid.steps = 30;
    options_.keep = {2, 1};
    options_.iterations = {3, 8};
    options_.angles = 72;
    problem_.fine = fine_.get();
    problem_.coarse = coarse_.get();
    problem_.material = test::TestMaterial();
    const State drape = test::Settled(*fine_, truth_, test::RandomStart(fine_->model(), 1));
    problem_.targets = {test::TargetOf(fine_->model().mesh, drape, options_.angles, "truth")};
    callbacks_.save = [this](const StagedFitState& state) { saved_.push_back(state); };
  }
  StagedFitState Run(const StagedFitState& from = {}) {
    return RunStagedFit(problem_, options_, from, callbacks_);
  }

  const std::unique_ptr<Backend> fine_ = test::SmoothDisc(150), coarse_ = test::SmoothDisc(100);
  const MaterialField truth_ = Scaled(test::TestMaterial(), 1.0, kTrueBend);
  FitProblem problem_;
  StagedFitOptions options_;
  StagedFitCallbacks callbacks_;
  std::vector<StagedFitState> saved_;
};

TEST_F(StagedFitTest, ComesNearTheOutline) {
  const StagedFitState state = Run();
  const BranchFit* best = Best(state);
  ASSERT_NE(best, nullptr);
  EXPECT_LT(best->profile_rms, 0.3);
  EXPECT_LT(best->profile_rms, 0.3 * best->seed_rms);
  EXPECT_EQ(state.round, 2);
  EXPECT_EQ(state.iterations > 0 && state.counts.tangents > 0, true);
  // The drape that is given belongs to the material that is given, and is at rest.
  const MaterialField fitted = FittedMaterial(problem_, options_, *best);
  EXPECT_LT(ForceResidual(fine_->model(), fitted, best->shapes[0]), 1e-8);
  EXPECT_EQ(FitJacobian(problem_, options_, *best).rows(), options_.angles);
}

// log(fit/truth) of (stretch, bend), along the directions that the data determine to 2 %.
TEST_F(StagedFitTest, UndoesAScalingOfTheStartWhereTheDataTell) {
  options_.parameters = Tying::kScales;
  problem_.material = Scaled(test::TestMaterial(), 1.0, kTrueBend / 4.0);
  const StagedFitState state = Run();
  const BranchFit* best = Best(state);
  ASSERT_NE(best, nullptr);
  const Eigen::Vector2d error(std::log(best->seed.stretch) + best->theta[0],
                              std::log(best->seed.bend / 4.0) + best->theta[1]);
  const Spectrum spectrum =
      SpectrumOf(FitJacobian(problem_, options_, *best), options_.prior_sigma);
  int determined = 0;
  for (int i = 0; i < 2; ++i) {
    if (spectrum.values[i] < 50.0) continue;
    ++determined;
    EXPECT_LT(std::fabs(spectrum.directions.col(i).dot(error)), 0.05) << spectrum.values[i];
  }
  EXPECT_GE(determined, 1);
}

TEST_F(StagedFitTest, GoesOnFromEachSavedStateToTheSameAnswer) {
  const StagedFitState whole = Run();
  const std::vector<StagedFitState> saved = saved_;
  ASSERT_GE(saved.size(), 4);  // the grid and three branches
  const BranchFit* best = Best(whole);
  ASSERT_NE(best, nullptr);
  for (std::size_t i = 0; i < saved.size(); ++i) {
    const StagedFitState resumed = Run(saved[i]);
    ASSERT_NE(Best(resumed), nullptr) << i;
    EXPECT_EQ(Best(resumed)->theta, best->theta) << i;
    EXPECT_EQ(Best(resumed)->shapes, best->shapes) << i;
    EXPECT_EQ(Best(resumed)->cost, best->cost) << i;
    EXPECT_EQ(resumed.iterations, whole.iterations) << i;
    EXPECT_EQ(resumed.counts.rollouts, whole.counts.rollouts) << i;
  }
}

TEST_F(StagedFitTest, ACancelGivesTheBestSoFar) {
  std::atomic<bool> cancel = false;
  callbacks_.cancel = &cancel;
  callbacks_.save = [&](const StagedFitState& state) { cancel = state.branch == 1; };
  const StagedFitState part = Run();
  EXPECT_EQ(part.round, 0);
  const BranchFit* best = Best(part);
  ASSERT_NE(best, nullptr);
  EXPECT_LT(best->profile_rms, best->seed_rms);
  EXPECT_LT(
      ForceResidual(fine_->model(), FittedMaterial(problem_, options_, *best), best->shapes[0]),
      1e-8);
}

TEST_F(StagedFitTest, ACancelWithinABranchIsNotSaved) {
  std::atomic<bool> cancel = false;
  callbacks_.cancel = &cancel;
  callbacks_.progress = [&](const std::string& stage, double, double) {
    if (stage == "round 2") cancel = true;
  };
  const StagedFitState part = Run();
  ASSERT_FALSE(saved_.empty());
  EXPECT_EQ(saved_.back().round, 1);
  EXPECT_EQ(saved_.back().branch, 0);
  EXPECT_NE(Best(part), nullptr);
  EXPECT_LE(Best(part)->cost, Best(saved_.back())->cost);
}

TEST_F(StagedFitTest, ACancelBeforeTheGridHasNoAnswer) {
  const std::atomic<bool> cancel = true;
  callbacks_.cancel = &cancel;
  EXPECT_EQ(Best(Run()), nullptr);
  EXPECT_TRUE(saved_.empty());
}

}  // namespace
}  // namespace drape
