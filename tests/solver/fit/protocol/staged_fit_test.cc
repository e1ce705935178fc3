// SPDX-License-Identifier: Apache-2.0
// The staged protocol on a small stiff cloth, whose few branches the seeds find.
#include "solver/fit/protocol/staged_fit.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "losses/outline/outline.h"
#include "solver/fit/fit.h"
#include "solver/fit/protocol/candidate_fit.h"
#include "tests/solver/fake_fit.h"
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
    options_.candidates_per_round = {2, 1};
    options_.iterations = {3, 8};
    problem_.fine = fine_.get();
    problem_.coarse = coarse_.get();
    problem_.material = test::TestMaterial();
    const State drape = test::Settled(*fine_, reference_, test::RandomStart(fine_->model(), 1));
    problem_.observations = {test::MakeObservation(fine_->model().mesh, drape, 72, "reference")};
    control_.save = [this](const StagedFitState& state) { saved_.push_back(state); };
  }
  StagedFitState Run(const StagedFitState& from = {}) {
    return RunStagedFit(problem_, options_, from, control_);
  }

  const std::unique_ptr<Backend> fine_ = test::SmoothDisc(150), coarse_ = test::SmoothDisc(100);
  const MaterialField reference_ = Scaled(test::TestMaterial(), 1.0, kTrueBend);
  FitProblem problem_;
  StagedFitOptions options_;
  StagedFitControl control_;
  std::vector<StagedFitState> saved_;
};

TEST_F(StagedFitTest, ComesNearTheOutline) {
  const StagedFitState state = Run();
  const FitCandidate* best = Best(state);
  ASSERT_NE(best, nullptr);
  EXPECT_LT(best->profile_rms, 0.3);
  EXPECT_LT(best->profile_rms, 0.3 * best->guess_rms);
  EXPECT_EQ(state.round, 2);
  EXPECT_EQ(state.iterations > 0 && state.counts.tangents > 0, true);
  // The drape that is given belongs to the material that is given, and is at rest.
  const MaterialField fitted = FittedMaterial(options_, *best);
  EXPECT_LT(ForceResidual(fine_->model(), fitted, best->shapes[0]), 1e-8);
  EXPECT_EQ(FitJacobian(problem_, options_, *best).rows(), 72);
}

TEST_F(StagedFitTest, EndsWhereNoGuessHasADrape) {
  options_.candidates_per_round = {2};
  options_.iterations = {1};
  options_.residuals.rollout.steps = 1;
  options_.residuals.equilibrium.max_iterations = 1;
  for (const bool is_pooled : {false, true}) {
    problem_.is_pooled = is_pooled;
    const StagedFitState state = Run();
    EXPECT_EQ(Best(state), nullptr);
    EXPECT_EQ(state.round, 1);
  }
}

TEST_F(StagedFitTest, ReportsSharesOfTheExpectedWork) {
  double guesses = 0.0, last = 0.0;
  control_.progress = [&](double fraction, const std::string& note) {
    EXPECT_LE(fraction, 1.0);
    if (note == "initial guesses") guesses = fraction;
    last = fraction;
  };
  Run();
  const FitWork work = ExpectFitWork(problem_, options_);
  EXPECT_DOUBLE_EQ(guesses, work.initial_guesses / work.total());
  EXPECT_GT(last, 0.6);
  options_.iterations = {3, 80};  // of which a fit usually takes half
  EXPECT_LT(ExpectFitWork(problem_, options_).rounds[1], 5 * work.rounds[1]);
}

// log(fit/reference) of (stretch, bend), along the directions that the data determine to 2 %.
TEST_F(StagedFitTest, UndoesAScalingOfTheStartWhereTheDataTell) {
  options_.parameters = ParameterTying::kScales;
  problem_.material = Scaled(test::TestMaterial(), 1.0, kTrueBend / 4.0);
  const StagedFitState state = Run();
  const FitCandidate* best = Best(state);
  ASSERT_NE(best, nullptr);
  const Eigen::Vector2d error(std::log(best->guess.stretch) + best->theta[0],
                              std::log(best->guess.bend / 4.0) + best->theta[1]);
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
  control_.cancel = &cancel;
  control_.save = [&](const StagedFitState& state) { cancel = Best(state) != nullptr; };
  const StagedFitState part = Run();
  EXPECT_EQ(part.round, 0);
  const FitCandidate* best = Best(part);
  ASSERT_NE(best, nullptr);
  EXPECT_LT(best->profile_rms, best->guess_rms);
  EXPECT_LT(ForceResidual(fine_->model(), FittedMaterial(options_, *best), best->shapes[0]), 1e-8);
}

TEST_F(StagedFitTest, ACancelWithinABranchIsNotSaved) {
  std::atomic<bool> cancel = false;
  control_.cancel = &cancel;
  control_.progress = [&](double, const std::string& note) {
    if (note.starts_with("round 2")) cancel = true;
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
  control_.cancel = &cancel;
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
    problem_.observations = {
        test::ObserveDrape(backend_, Scaled(test::TestMaterial(), 3.0, 1.5), 90)};
    options_.candidates_per_round = {8, 3, 1};
    options_.iterations = {2, 3, 6};
    control_.save = [this](const StagedFitState& state) { saved_.push_back(state); };
    control_.log = [this](const std::string& line) { said_ += line + "\n"; };
    control_.progress = [this](double fraction, const std::string& note) {
      said_ += note + " " + std::to_string(fraction) + "\n";
    };
  }
  StagedFitState Run(const StagedFitState& from = {}) {
    saved_.clear();
    said_.clear();
    return RunStagedFit(problem_, options_, from, control_);
  }
  static void ExpectSame(const StagedFitState& a, const StagedFitState& b) {
    EXPECT_EQ(a.round, b.round);
    EXPECT_EQ(a.iterations, b.iterations);
    EXPECT_EQ(a.counts.rollouts, b.counts.rollouts);
    EXPECT_EQ(a.counts.failed, b.counts.failed);
    ASSERT_EQ(a.candidates.size(), b.candidates.size());
    for (std::size_t i = 0; i < a.candidates.size(); ++i) {
      EXPECT_EQ(a.candidates[i].theta, b.candidates[i].theta) << i;
      EXPECT_EQ(a.candidates[i].shapes, b.candidates[i].shapes) << i;
      EXPECT_EQ(a.candidates[i].cost, b.candidates[i].cost) << i;
      EXPECT_EQ(a.candidates[i].done, b.candidates[i].done) << i;
    }
  }
  test::FakeBackend backend_, coarse_;
  FitProblem problem_;
  StagedFitOptions options_;
  StagedFitControl control_;
  std::vector<StagedFitState> saved_;
  std::string said_;
};

TEST_F(ManyCandidatesTest, BranchesOfARoundShareTheirBatches) {
  options_.candidates_per_round = {64};
  options_.iterations = {20};
  options_.grid.bend.clear();
  for (int k = 0; k < 22; ++k) options_.grid.bend.push_back(std::exp2(3.0 - k / 3.0));
  const StagedFitState state = Run();
  EXPECT_EQ(backend_.largest_batch, 64);
  EXPECT_EQ(std::count_if(state.candidates.begin(), state.candidates.end(),
                          [](const FitCandidate& candidate) { return candidate.valid(); }),
            64);
  EXPECT_LT(Best(state)->profile_rms, 0.01);
  EXPECT_THAT(said_, testing::Not(testing::HasSubstr("starts of")));
}

TEST_F(ManyCandidatesTest, FewerStartsThanAskedForAreSaid) {
  options_.candidates_per_round = {64};
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
  options_.candidates_per_round = {8};
  options_.iterations = {4};
  const StagedFitState all = Run();
  StagedFitState one = *std::find_if(saved_.begin(), saved_.end(),
                                     [](const StagedFitState& state) { return state.grid_done; });
  std::size_t last = all.candidates.size() - 1;
  while (!all.candidates[last].valid()) --last;
  ASSERT_GE(last, 7);
  for (std::size_t i = 0; i < one.candidates.size(); ++i) one.candidates[i].done = i != last;
  const StagedFitState alone = Run(one);
  EXPECT_EQ(alone.candidates[last].theta, all.candidates[last].theta);
  EXPECT_EQ(alone.candidates[last].shapes, all.candidates[last].shapes);
}

// Seeds without drapes, seeds that fall into the same drape, branches that end apart.
TEST_F(ManyCandidatesTest, GoesOnFromEachSavedStateToTheSameAnswer) {
  backend_.fails = [](double s, double b) { return b > 0.5 && b < 1.0 && s < 1.0; };
  const StagedFitState whole = Run();
  const std::vector<StagedFitState> saved = saved_;
  EXPECT_TRUE(std::any_of(saved.begin(), saved.end(), [](const StagedFitState& state) {
    return !std::is_partitioned(state.candidates.begin(), state.candidates.end(),
                                [](const FitCandidate& candidate) { return candidate.done; });
  }));
  for (const StagedFitState& state : saved) ExpectSame(Run(state), whole);
}

TEST_F(ManyCandidatesTest, AnErrorOfTheSaverEndsTheFit) {
  control_.save = [](const StagedFitState& state) {
    if (DoneCandidates(state) == 2) throw std::runtime_error("full disk");
  };
  EXPECT_THROW(Run(), std::runtime_error);
}

}  // namespace
}  // namespace drape
