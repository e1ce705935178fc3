// SPDX-License-Identifier: Apache-2.0
// What a posterior begins with and what it shows.
#include "solver/posterior/map_estimator.h"

#include <gtest/gtest.h>

#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

// One silhouette of the start tables themselves.
class PosteriorModeTest : public testing::Test {
 protected:
  PosteriorModeTest() {
    staged_.parameters = ParameterTying::kScales;
    staged_.angles = 72;
    problem_.fine = backend_.get();
    problem_.material = test::TestMaterial();
    const State drape =
        test::Settled(*backend_, problem_.material, test::RandomStart(backend_->model(), 1));
    problem_.targets = {
        test::MakeObservation(backend_->model().mesh, drape, staged_.angles, "truth")};
    branch_.seed.lifts = {1.0};
    branch_.theta = Eigen::VectorXd::Zero(2);
    branch_.shapes = {drape.x};
  }
  // How far the drape that is shown is from rest under its material.
  double Residual() const {
    return ForceResidual(backend_->model(), fit_.materials.at(0), fit_.shapes.at(0));
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(120);
  FitProblem problem_;
  StagedFitOptions staged_;
  PosteriorOptions options_;
  FitCandidate branch_;
  const StagedFitCallbacks callbacks_;
  PosteriorFit fit_;
};

TEST_F(PosteriorModeTest, ShowsTheDrapesOfTheMean) {
  MapEstimator mode(problem_, staged_, options_, branch_, callbacks_, &fit_);
  ASSERT_TRUE(mode.Find());
  Eigen::VectorXd mean = fit_.mode.gaussian.mean;
  mean[1] += 0.3;
  ASSERT_TRUE(mode.KeepDrapes(mean));
  EXPECT_FALSE(fit_.shown_at_mode);
  EXPECT_LT(Residual(), 1e-8);
  EXPECT_NE(fit_.materials[0].bend[0].b[0][0],
            fit_.FabricAt(fit_.mode.gaussian.mean).bend[0].b[0][0]);
}

// A distribution is not lost because a drape at its mean is.
TEST_F(PosteriorModeTest, WhereTheWayToTheMeanEndsItShowsTheMode) {
  MapEstimator mode(problem_, staged_, options_, branch_, callbacks_, &fit_);
  ASSERT_TRUE(mode.Find());
  const Eigen::VectorXd at_mode = fit_.mode.gaussian.mean;
  Eigen::VectorXd mean = at_mode;
  mean[1] += 0.3;
  staged_.max_jump = 1e-12;
  ASSERT_TRUE(mode.KeepDrapes(mean));
  EXPECT_TRUE(fit_.shown_at_mode);
  EXPECT_LT(Residual(), 1e-8);
  const double specimen = options_.specimen_bend_sigma * at_mode[3];
  EXPECT_NEAR(fit_.materials[0].bend[0].b[0][0],
              fit_.FabricAt(at_mode).bend[0].b[0][0] * std::exp(specimen),
              1e-12 * fit_.materials[0].bend[0].b[0][0]);
}

// Elements whose drapes are lost however little they scatter have a distribution by tangents.
TEST_F(PosteriorModeTest, ScatterIsCarriedOnFromTheModeWhereNoDrapeStands) {
  staged_.parameters = ParameterTying::kEntries;
  branch_.theta = Eigen::VectorXd::Zero(kMaterialEntries);
  options_.kind = PosteriorKind::kElements;
  options_.element_sigma = 300;  // of logarithms: no cloth of such elements stands
  options_.draws = 2;
  options_.iterations = 2;
  options_.elbo_samples = 25;
  MapEstimator mode(problem_, staged_, options_, branch_, callbacks_, &fit_);
  ASSERT_TRUE(mode.Find());
  ASSERT_TRUE(FitElements(problem_, options_, mode, &fit_));
  EXPECT_EQ(fit_.beyond, 2);
  EXPECT_EQ(fit_.fresh, 0);
}

}  // namespace
}  // namespace drape
