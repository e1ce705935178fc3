// SPDX-License-Identifier: Apache-2.0
// The optimiser's loop on an analytic drape with a known minimum.
#include "solver/fit/fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "losses/outline/outline.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/solver/fake_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

const Eigen::Vector2d kTruth(0.6, -0.4);

class FitTest : public testing::Test {
 protected:
  FitTest() {
    outline_options_.sigma_px = 0.1;
    outline_options_.max_jump = 1.0;
    fit_options_.prior_sigma = 1e6;
    fit_options_.trust_region.cost_tolerance = 1e-12;
    fit_options_.trust_region.initial_damping = 1e-2;
    AddObservation(kTruth);
  }
  MaterialField Material(const Eigen::Vector2d& theta) const {
    return parametrisation_.Material(theta);
  }
  void AddObservation(const Eigen::Vector2d& reference) {
    observations_.push_back(test::ObserveDrape(backend_, Material(reference), 90));
    starts_.push_back(backend_.model().RestState());
  }
  FitSummary RunFit() {
    outlines_ = std::make_unique<RolloutResiduals>(ObservationResiduals(
        &backend_, &parametrisation_, observations_, starts_, outline_options_));
    return Fit(*outlines_, fit_options_);
  }
  // The starts are the drapes of the point that is returned, which has the least cost.
  void ExpectConsistent(const FitSummary& summary) const {
    ASSERT_EQ(summary.theta.size(), 2);
    for (const State& start : outlines_->starts())
      EXPECT_EQ(start.x, backend_.Shape(Material(summary.theta)));
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    for (const FitIteration& iteration : summary.iterations)
      EXPECT_LE(summary.final_cost, iteration.cost * (1 + 1e-12)) << iteration.iteration;
  }

  test::FakeBackend backend_;
  TableParametrisation parametrisation_{test::TestMaterial(), ParameterTying::kScales};
  std::vector<Observation> observations_;
  std::vector<State> starts_;
  ResidualOptions outline_options_ = test::CloseOutlineOptions();
  FitOptions fit_options_;
  std::unique_ptr<RolloutResiduals> outlines_;
};

TEST_F(FitTest, ConvergesToTheKnownMinimum) {
  const FitSummary summary = RunFit();
  EXPECT_EQ(summary.termination, FitTermination::kConverged) << summary.message;
  EXPECT_LT((summary.theta - kTruth).norm(), 1e-6) << summary.theta.transpose();
  EXPECT_LT(summary.final_cost, 1e-8 * summary.initial_cost);
  EXPECT_EQ(summary.counts.failed + summary.counts.jumps, 0);
  EXPECT_EQ(summary.counts.rollouts, backend_.equilibria);
  EXPECT_EQ(summary.jacobian.rows(), 90);
  ExpectConsistent(summary);
}

TEST_F(FitTest, TheDynamicIntegratorFindsTheSame) {
  outline_options_.solve_mode = SolveMode::kDynamic;
  const FitSummary summary = RunFit();
  EXPECT_EQ(backend_.equilibria, 0);
  EXPECT_LT((summary.theta - kTruth).norm(), 1e-6) << summary.theta.transpose();
  ExpectConsistent(summary);
}

// The drape is linear in tanh θ, the residual in it: at the ridge solution the gradient of
// ½‖r(θ)‖² + ½‖θ/σ‖² vanishes, which the exact Jacobian tells.
TEST_F(FitTest, AStrongPriorGivesTheRidgeSolution) {
  fit_options_.prior_sigma = 1e-3;
  const FitSummary summary = RunFit();
  EXPECT_LT(summary.theta.norm(), 0.98 * kTruth.norm());
  EXPECT_GT(summary.theta.norm(), 0.01);
  outlines_->PrepareForEvaluation(true, true);
  const Eigen::VectorXd gradient =
      summary.jacobian.transpose() * outlines_->accepted().residual +
      summary.theta / (fit_options_.prior_sigma * fit_options_.prior_sigma);
  const double scale = (summary.theta / std::pow(fit_options_.prior_sigma, 2)).norm();
  EXPECT_LT(gradient.norm(), 1e-4 * scale);
  EXPECT_NEAR(summary.final_cost,
              0.5 * outlines_->accepted().residual.squaredNorm() +
                  0.5 * (summary.theta / fit_options_.prior_sigma).squaredNorm(),
              1e-9 * summary.final_cost);
}

TEST_F(FitTest, TwoTargetsShareOneMaterial) {
  AddObservation(Eigen::Vector2d(0.7, -0.2));
  const FitSummary summary = RunFit();
  EXPECT_EQ(summary.jacobian.rows(), 180);
  EXPECT_GT(summary.theta[0], 0.6);
  EXPECT_LT(summary.theta[0], 0.7);
  EXPECT_GT(summary.theta[1], -0.4);
  EXPECT_LT(summary.theta[1], -0.2);
  ExpectConsistent(summary);
}

// The minimum lies in a region without drapes: the fit comes to its rim.
TEST_F(FitTest, AFailedTrialShortensTheStep) {
  backend_.fails = [](double s, double b) {
    return (Eigen::Vector2d(s, b) - kTruth).norm() < 0.05;
  };
  fit_options_.trust_region.max_iterations = 60;
  const FitSummary summary = RunFit();
  EXPECT_GT(summary.counts.failed, 0);
  EXPECT_GE((summary.theta - kTruth).norm(), 0.05);
  EXPECT_LT(summary.final_cost, 0.1 * summary.initial_cost);
  const auto failed =
      std::find_if(summary.iterations.begin() + 1, summary.iterations.end(),
                   [](const FitIteration& iteration) { return !iteration.accepted; });
  ASSERT_NE(failed, summary.iterations.end());
  EXPECT_LT(failed->trust_radius, (failed - 1)->trust_radius);
  ExpectConsistent(summary);
}

TEST_F(FitTest, StallsWhereDerivativesAreMissing) {
  backend_.unstable = [](double s, double) { return s > 0.3; };
  const FitSummary summary = RunFit();
  EXPECT_EQ(summary.termination, FitTermination::kStalled) << summary.message;
  EXPECT_LE(summary.theta[0], 0.3);
  EXPECT_EQ(summary.jacobian.rows(), 90);
  ExpectConsistent(summary);
}

TEST_F(FitTest, AJumpToAnotherBranchIsRefusedAndCounted) {
  backend_.other_branch = [](double s, double) { return s > 0.3; };
  outline_options_.max_jump = 5e-3;
  fit_options_.trust_region.max_iterations = 60;
  const FitSummary summary = RunFit();
  EXPECT_GT(summary.counts.jumps, 0);
  EXPECT_EQ(summary.counts.failed, 0);
  EXPECT_LE(summary.theta[0], 0.3);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  ExpectConsistent(summary);
}

TEST_F(FitTest, StopsWhenTheDampingIsTooLarge) {
  backend_.fails = [](double s, double b) { return s != 0.0 || b != 0.0; };
  fit_options_.trust_region.max_damping = 10.0;
  const FitSummary summary = RunFit();
  EXPECT_EQ(summary.termination, FitTermination::kDampingLimit) << summary.message;
  EXPECT_EQ(summary.theta, Eigen::Vector2d::Zero());
  EXPECT_GT(summary.counts.failed, 1);
  ExpectConsistent(summary);
}

TEST_F(FitTest, CancelEndsAfterTheIteration) {
  std::atomic<bool> cancel = false;
  fit_options_.trust_region.cancel = &cancel;
  fit_options_.trust_region.progress = [&](const FitIteration& iteration) {
    cancel = iteration.iteration == 1;
  };
  const FitSummary summary = RunFit();
  EXPECT_EQ(summary.termination, FitTermination::kCancelled);
  EXPECT_EQ(summary.iterations.size(), 2);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  ExpectConsistent(summary);
}

TEST_F(FitTest, TheIterationLimitKeepsTheBestPoint) {
  fit_options_.trust_region.max_iterations = 1;
  const FitSummary summary = RunFit();
  EXPECT_EQ(summary.termination, FitTermination::kIterationLimit);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  ExpectConsistent(summary);
}

TEST_F(FitTest, AStartThatCannotBeEvaluatedFails) {
  backend_.fails = [](double, double) { return true; };
  const FitSummary summary = RunFit();
  EXPECT_EQ(summary.termination, FitTermination::kFailed);
  EXPECT_EQ(summary.theta.size(), 0);
  EXPECT_EQ(outlines_->starts()[0].x, backend_.model().mesh.rest_x);
  EXPECT_FALSE(outlines_->has_accepted());
}

TEST(FitTermination, HasAWordForEach) {
  for (int i = 0; i <= static_cast<int>(FitTermination::kFailed); ++i)
    EXPECT_STRNE(ToString(static_cast<FitTermination>(i)), "") << i;
}

Eigen::MatrixXd Rotation(int size, std::mt19937_64& random) {
  const Eigen::MatrixXd noise = test::RandomMatrix(size, size, random);
  return Eigen::HouseholderQR<Eigen::MatrixXd>(noise).householderQ();
}

TEST(Spectrum, FindsValuesAndDirectionsOfAKnownJacobian) {
  std::mt19937_64 random(3);
  const Eigen::MatrixXd u = Rotation(6, random), v = Rotation(4, random);
  const Eigen::Vector4d values(20.0, 3.0, 0.8, 0.1);
  const Spectrum spectrum =
      ComputeSpectrum(u.leftCols(4) * values.asDiagonal() * v.transpose(), 1.0);
  EXPECT_LT((spectrum.values - values).norm(), 1e-12);
  EXPECT_EQ(spectrum.determined, 2);
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(std::fabs(spectrum.directions.col(i).dot(v.col(i))), 1.0, 1e-12) << i;
}

TEST(Spectrum, AWiderPriorLeavesMoreToTheData) {
  const Eigen::MatrixXd jacobian = Eigen::Vector3d(20.0, 3.0, 0.8).asDiagonal();
  EXPECT_EQ(ComputeSpectrum(jacobian, 0.1).determined, 1);
  EXPECT_EQ(ComputeSpectrum(jacobian, 1.0).determined, 2);
  EXPECT_EQ(ComputeSpectrum(jacobian, 10.0).determined, 3);
}

TEST(Spectrum, FewerResidualsThanParametersLeaveDirectionsUndetermined) {
  std::mt19937_64 random(4);
  const Eigen::MatrixXd jacobian = test::RandomMatrix(2, 5, random);
  const Spectrum spectrum = ComputeSpectrum(jacobian, 100.0);
  ASSERT_EQ(spectrum.values.size(), 5);
  EXPECT_GT(spectrum.values[1], 0.0);
  EXPECT_EQ(spectrum.values.tail(3), Eigen::Vector3d::Zero());
  EXPECT_EQ(spectrum.determined, 2);
  EXPECT_LT((jacobian * spectrum.directions.rightCols(3)).norm(), 1e-13);
  const Eigen::MatrixXd gram = spectrum.directions.transpose() * spectrum.directions;
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(5, 5)).norm(), 1e-13);
}

}  // namespace
}  // namespace drape
