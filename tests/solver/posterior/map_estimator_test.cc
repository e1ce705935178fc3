// SPDX-License-Identifier: Apache-2.0
// The mode that a posterior starts with, and the drapes that it reports.
#include <gtest/gtest.h>

#include "solver/posterior/posterior_fit.h"
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
  Eigen::VectorXd mean = fit_.mode.gaussian.mean;
  mean[1] += 0.3;
  ASSERT_TRUE(mode.ReportDrapes(mean));
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
  Eigen::VectorXd mean = at_mode;
  mean[1] += 0.3;
  staged_.residuals.max_jump = 1e-12;
  ASSERT_TRUE(mode.ReportDrapes(mean));
  EXPECT_TRUE(fit_.reported_at_mode);
  EXPECT_LT(Residual(), 1e-8);
  const double specimen = options_.specimen_bend_sigma * at_mode[3];
  EXPECT_NEAR(fit_.materials[0].bend[0].b[0][0],
              fit_.FabricAt(at_mode).bend[0].b[0][0] * std::exp(specimen),
              1e-12 * fit_.materials[0].bend[0].b[0][0]);
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

}  // namespace
}  // namespace drape
