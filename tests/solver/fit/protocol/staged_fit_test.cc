// SPDX-License-Identifier: Apache-2.0
// The staged protocol on a small stiff cloth, whose few branches the seeds find.
#include "solver/fit/protocol/staged_fit.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "losses/outline/outline.h"
#include "solver/fit/spectrum.h"
#include "tests/solver/fake_backend.h"
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
    problem_.targets = {
        test::MakeObservation(fine_->model().mesh, drape, options_.angles, "truth")};
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
  const FitCandidate* best = Best(state);
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
  options_.parameters = ParameterTying::kScales;
  problem_.material = Scaled(test::TestMaterial(), 1.0, kTrueBend / 4.0);
  const StagedFitState state = Run();
  const FitCandidate* best = Best(state);
  ASSERT_NE(best, nullptr);
  const Eigen::Vector2d error(std::log(best->seed.stretch) + best->theta[0],
                              std::log(best->seed.bend / 4.0) + best->theta[1]);
  const Spectrum spectrum =
      ComputeSpectrum(FitJacobian(problem_, options_, *best), options_.prior_sigma);
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
  const FitCandidate* best = Best(whole);
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
  callbacks_.save = [&](const StagedFitState& state) { cancel = Best(state) != nullptr; };
  const StagedFitState part = Run();
  EXPECT_EQ(part.round, 0);
  const FitCandidate* best = Best(part);
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
  EXPECT_EQ(DoneCandidates(saved_.back()), 0);
  EXPECT_NE(Best(part), nullptr);
  EXPECT_LE(Best(part)->cost, Best(saved_.back())->cost);
}

TEST_F(StagedFitTest, ACancelBeforeTheGridHasNoAnswer) {
  const std::atomic<bool> cancel = true;
  callbacks_.cancel = &cancel;
  EXPECT_EQ(Best(Run()), nullptr);
  EXPECT_TRUE(saved_.empty());
}

// Without physics, so that many branches cost little.
class ManyCandidatesTest : public testing::Test {
 protected:
  ManyCandidatesTest() {
    problem_.fine = &backend_;
    problem_.coarse = &coarse_;
    problem_.material = test::TestMaterial();
    Observation target;
    Outline outline;
    EXPECT_TRUE(OutlineFromMesh(backend_.model().mesh,
                                backend_.Shape(Scaled(test::TestMaterial(), 3.0, 1.5)),
                                target.camera, options_.angles, &outline));
    target.radius = outline.radius;
    problem_.targets = {target};
    options_.keep = {8, 3, 1};
    options_.iterations = {2, 3, 6};
    callbacks_.save = [this](const StagedFitState& state) { saved_.push_back(state); };
    callbacks_.log = [this](const std::string& line) { said_ += line + "\n"; };
    callbacks_.progress = [this](const std::string& stage, double share, double rms) {
      said_ += stage + " " + std::to_string(share) + " " + std::to_string(rms) + "\n";
    };
  }
  StagedFitState Run(const StagedFitState& from = {}) {
    saved_.clear();
    said_.clear();
    return RunStagedFit(problem_, options_, from, callbacks_);
  }
  static void ExpectSame(const StagedFitState& a, const StagedFitState& b) {
    EXPECT_EQ(a.round, b.round);
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(a.counts.rollouts, b.counts.rollouts);
    EXPECT_EQ(a.counts.failed, b.counts.failed);
    ASSERT_EQ(a.branches.size(), b.branches.size());
    for (std::size_t i = 0; i < a.branches.size(); ++i) {
      EXPECT_EQ(a.branches[i].theta, b.branches[i].theta) << i;
      EXPECT_EQ(a.branches[i].shapes, b.branches[i].shapes) << i;
      EXPECT_EQ(a.branches[i].cost, b.branches[i].cost) << i;
      EXPECT_EQ(a.branches[i].done, b.branches[i].done) << i;
    }
  }
  test::FakeBackend backend_, coarse_;
  FitProblem problem_;
  StagedFitOptions options_;
  StagedFitCallbacks callbacks_;
  std::vector<StagedFitState> saved_;
  std::string said_;
};

TEST_F(ManyCandidatesTest, BranchesOfARoundShareTheirBatches) {
  options_.keep = {64};
  options_.iterations = {20};
  const StagedFitState state = Run();
  EXPECT_EQ(backend_.largest_batch, 64);
  EXPECT_EQ(std::count_if(state.branches.begin(), state.branches.end(),
                          [](const FitCandidate& branch) { return branch.valid(); }),
            64);
  EXPECT_LT(Best(state)->profile_rms, 0.01);
  EXPECT_THAT(said_, testing::Not(testing::HasSubstr("starts of")));
}

TEST_F(ManyCandidatesTest, FewerStartsThanAskedForAreSaid) {
  options_.keep = {64};
  options_.iterations = {1};
  options_.grid.stretch = {1.0};
  options_.grid.bend = {2.0};
  Run();
  EXPECT_THAT(said_, testing::HasSubstr("round 1: 1 starts of 64"));
}

TEST_F(ManyCandidatesTest, WhatIsSaidAndSavedDoesNotDependOnTiming) {
  const StagedFitState once = Run();
  const std::vector<StagedFitState> saved = saved_;
  const std::string said = said_;
  EXPECT_GT(saved.size(), 12);
  for (int again = 0; again < 3; ++again) {
    ExpectSame(Run(), once);
    EXPECT_EQ(said_, said);
    ASSERT_EQ(saved_.size(), saved.size());
    for (std::size_t i = 0; i < saved.size(); ++i) ExpectSame(saved_[i], saved[i]);
  }
}

// A branch's fit is that of the branch alone.
TEST_F(ManyCandidatesTest, ABranchDoesNotFeelItsNeighbours) {
  options_.keep = {8};
  options_.iterations = {4};
  const StagedFitState all = Run();
  StagedFitState one = saved_.front();
  std::size_t last = all.branches.size() - 1;
  while (!all.branches[last].valid()) --last;
  ASSERT_GE(last, 7);
  for (std::size_t i = 0; i < one.branches.size(); ++i) one.branches[i].done = i != last;
  const StagedFitState alone = Run(one);
  EXPECT_EQ(alone.branches[last].theta, all.branches[last].theta);
  EXPECT_EQ(alone.branches[last].shapes, all.branches[last].shapes);
}

// Seeds without drapes, seeds that fall into the same drape, branches that end apart.
TEST_F(ManyCandidatesTest, GoesOnFromEachSavedStateToTheSameAnswer) {
  backend_.fails = [](double s, double b) { return b > 0.5 && b < 1.0 && s < 1.0; };
  const StagedFitState whole = Run();
  const std::vector<StagedFitState> saved = saved_;
  EXPECT_TRUE(std::any_of(saved.begin(), saved.end(), [](const StagedFitState& state) {
    return !std::is_partitioned(state.branches.begin(), state.branches.end(),
                                [](const FitCandidate& branch) { return branch.done; });
  }));
  for (const StagedFitState& state : saved) ExpectSame(Run(state), whole);
}

TEST_F(ManyCandidatesTest, AnErrorOfTheSaverEndsTheFit) {
  callbacks_.save = [](const StagedFitState& state) {
    if (DoneCandidates(state) == 2) throw std::runtime_error("full disk");
  };
  EXPECT_THROW(Run(), std::runtime_error);
}

}  // namespace
}  // namespace drape
