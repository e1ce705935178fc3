// SPDX-License-Identifier: Apache-2.0
// The mode that a posterior starts with, and the drapes that it reports.
#include "solver/posterior/posterior_fit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "solver/posterior/variational_fit.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

// One silhouette of the start tables themselves.
class MapEstimatorTest : public testing::Test {
 protected:
  MapEstimatorTest() {
    staged_.parameters = ParameterTying::kScales;
    problem_.fine = backend_.get();
    problem_.material = candidate_.base = test::TestMaterial();
    const State drape =
        test::Settled(*backend_, problem_.material, test::RandomStart(backend_->model(), 1));
    problem_.observations = {test::MakeObservation(backend_->model().mesh, drape, 72, "reference")};
    candidate_.guess.lifts = {1.0};
    candidate_.theta = Eigen::VectorXd::Zero(2);
    candidate_.shapes = {drape.x};
  }
  // Makes a distribution that is not about the mode.
  void MoveDistribution() {
    fit_.distribution = fit_.mode;
    fit_.distribution.gaussian.mean[1] += 0.3;
  }
  // How far the reported drape is from equilibrium under its material.
  double Residual() const {
    return ForceResidual(backend_->model(), fit_.materials.at(0), fit_.shapes.at(0));
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(120);
  FitProblem problem_;
  StagedFitOptions staged_;
  PosteriorOptions options_;
  FitCandidate candidate_;
  const RunControl control_;
  PosteriorFit fit_;
};

TEST_F(MapEstimatorTest, ReportsTheDrapesOfTheMean) {
  MapEstimator mode(problem_, staged_, options_, candidate_, control_, &fit_);
  ASSERT_TRUE(mode.Find());
  MoveDistribution();
  ASSERT_TRUE(mode.ReportDrapes());
  EXPECT_FALSE(fit_.reported_at_mode);
  EXPECT_LT(Residual(), 1e-8);
  EXPECT_NE(fit_.materials[0].bend[0].b[0][0],
            fit_.FabricAt(fit_.mode.gaussian.mean).bend[0].b[0][0]);
}

// A distribution stays valid if a drape at its mean is lost.
TEST_F(MapEstimatorTest, ReportsTheModeIfTheBranchEndsBeforeTheMean) {
  MapEstimator mode(problem_, staged_, options_, candidate_, control_, &fit_);
  ASSERT_TRUE(mode.Find());
  const Eigen::VectorXd at_mode = fit_.mode.gaussian.mean;
  MoveDistribution();
  staged_.residuals.max_jump = 1e-12;
  ASSERT_TRUE(mode.ReportDrapes());
  EXPECT_TRUE(fit_.reported_at_mode);
  EXPECT_LT(Residual(), 1e-8);
  const double specimen = options_.specimen_bend_sigma * at_mode[3];
  EXPECT_NEAR(fit_.materials[0].bend[0].b[0][0],
              fit_.FabricAt(at_mode).bend[0].b[0][0] * std::exp(specimen),
              1e-12 * fit_.materials[0].bend[0].b[0][0]);
}

// Without enough independent samples the mean may be far from all that the data allow.
TEST_F(MapEstimatorTest, ReportsTheModeIfNothingConfirmsTheDistribution) {
  MapEstimator mode(problem_, staged_, options_, candidate_, control_, &fit_);
  ASSERT_TRUE(mode.Find());
  MoveDistribution();
  EstimateElbo({}, {}, &fit_);
  ASSERT_TRUE(mode.ReportDrapes());
  EXPECT_TRUE(fit_.reported_at_mode);
  EXPECT_LT(Residual(), 1e-8);
  EXPECT_EQ(fit_.Fabric().bend[0].b[0][0], fit_.FabricAt(fit_.mode.gaussian.mean).bend[0].b[0][0]);
}

// Elements whose drapes are lost however little they scatter have an extrapolated distribution.
TEST_F(MapEstimatorTest, ScatterIsExtrapolatedFromTheModeIfNoDrapeIsStable) {
  staged_.parameters = ParameterTying::kEntries;
  candidate_.theta = Eigen::VectorXd::Zero(kMaterialEntries);
  options_.kind = PosteriorKind::kElements;
  options_.element_sigma = 300;  // of logarithms: no cloth of such elements has a stable drape
  options_.draws = 2;
  options_.iterations = 2;
  options_.elbo_samples = 25;
  MapEstimator mode(problem_, staged_, options_, candidate_, control_, &fit_);
  ASSERT_TRUE(mode.Find());
  ASSERT_TRUE(FitElements(problem_, options_, mode, &fit_));
  EXPECT_EQ(fit_.num_extrapolated, 2);
  EXPECT_EQ(fit_.elbo_samples_valid, 0);
}

GaussianPosterior Example() {
  GaussianPosterior q;
  q.mean = Eigen::Vector3d(0.3, -1.0, 0.5);
  q.rotation = FromCovariance(q.mean, Eigen::Matrix3d{{2, 1, 0}, {1, 2, .5}, {0, .5, 1}}).rotation;
  q.factor = Eigen::Matrix3d{{.5, 0, 0}, {.2, .7, 0}, {-.1, .3, 1.2}};
  return q;
}

// ½ (tr Σ + |mean|² − P − ln det Σ).
TEST(GaussianPosterior, DivergenceIsThatOfItsCovariance) {
  const GaussianPosterior q = Example();
  const Eigen::MatrixXd covariance = q.Covariance();
  EXPECT_NEAR(
      q.DivergenceFromPrior(),
      0.5 * (covariance.trace() + q.mean.squaredNorm() - 3 - std::log(covariance.determinant())),
      1e-12);
}

TEST(GaussianPosterior, FromCovarianceKeepsItAndSortsItsAxes) {
  const Eigen::MatrixXd covariance = Example().Covariance();
  const GaussianPosterior q = FromCovariance(Eigen::Vector3d::Zero(), covariance);
  EXPECT_LT((q.Covariance() - covariance).norm(), 1e-14);
  EXPECT_LT(q.factor(0, 0), q.factor(2, 2));
  EXPECT_EQ(q.factor(1, 0), 0.0);
}

TEST(GaussianPosterior, ManyDrawsHaveItsMoments) {
  const GaussianPosterior q = Example();
  constexpr int kCount = 40000;
  const Eigen::MatrixXd draws = q.Draws(IndependentSamples(3, kCount, 11));
  EXPECT_LT((draws.rowwise().mean() - q.mean).norm(), 0.03);
  const Eigen::MatrixXd about = draws.colwise() - q.mean;
  EXPECT_LT((about * about.transpose() / kCount - q.Covariance()).norm(), 0.05);
}

TEST(BalancedSamples, HaveExactMoments) {
  const Eigen::MatrixXd draws = BalancedSamples(7, 10, 3);
  EXPECT_LT(draws.rowwise().sum().norm(), 1e-13);
  const Eigen::MatrixXd moments = draws * draws.transpose() / 10;
  EXPECT_LT((moments.topLeftCorner(5, 5) - Eigen::MatrixXd::Identity(5, 5)).norm(), 1e-12);
  EXPECT_EQ(draws, BalancedSamples(7, 10, 3));
  EXPECT_NE(draws, BalancedSamples(7, 10, 4));
}

// Weights u^−k of uniform u have a tail of shape k.
TEST(ParetoShape, FindsTheShapeOfAKnownTail) {
  for (const double k : {0.2, 0.5, 0.9}) {
    constexpr int kCount = 20000;
    Eigen::VectorXd log_weights(kCount);
    for (int i = 0; i < kCount; ++i) log_weights[i] = -k * std::log((i + 0.5) / kCount);
    EXPECT_NEAR(ParetoShape(log_weights), k, 0.05);
  }
}

TEST(ParetoShape, EqualWeightsHaveNoTail) {
  Eigen::VectorXd log_weights = Eigen::VectorXd::Constant(100, 2.0);
  EXPECT_EQ(ParetoShape(log_weights), 0.0);
  log_weights[3] = 9.0;
  EXPECT_TRUE(std::isinf(ParetoShape(log_weights)));
}

PosteriorFit ScoreOfEqualDraws(int count) {
  PosteriorFit fit;
  fit.sigma = 2.0;
  fit.independent = 4;
  const Eigen::VectorXd residual = Eigen::VectorXd::Constant(4, 0.5);
  EstimateElbo(std::vector<Eigen::VectorXd>(count, residual), std::vector<double>(count, -3.0),
               &fit);
  return fit;
}

TEST(EstimateElbo, IsTheMeanLogWeight) {
  const PosteriorFit fit = ScoreOfEqualDraws(30);
  EXPECT_NEAR(fit.elbo, -3.0 - 0.5 - 4 * std::log(2 * std::sqrt(2 * std::numbers::pi)), 1e-12);
  EXPECT_NEAR(fit.elbo_error, 0.0, 1e-12);
  EXPECT_NEAR(fit.sample_rms, 1.0, 1e-12);
  EXPECT_EQ(fit.elbo_samples_valid, 30);
}

TEST(EstimateElbo, TooFewDrawsSayNothing) {
  const PosteriorFit fit = ScoreOfEqualDraws(24);
  EXPECT_TRUE(std::isnan(fit.elbo));
  EXPECT_TRUE(std::isnan(fit.pareto_k));
  EXPECT_EQ(fit.elbo_samples_valid, 24);
}

}  // namespace
}  // namespace drape
