// SPDX-License-Identifier: Apache-2.0
// The mixture behind noisy observations [Bovy 2011].
#include <gtest/gtest.h>

#include <cmath>

#include "physics/util/math/random.h"
#include "solver/posterior/space/normal_mixture.h"
#include "solver/posterior/variational_fit.h"

namespace drape::test {
namespace {

// Two populations in a plane, seen with noise that differs from one observation to another and is
// as large as their scatter.
std::vector<NormalDistribution> Planted(int count, double distance) {
  const Eigen::MatrixXd standard = IndependentSamples(4, count, 11);
  std::vector<NormalDistribution> seen;
  for (int i = 0; i < count; ++i) {
    const bool first = i % 3 != 0;
    Eigen::Vector2d x = first ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(distance, 1);
    x += Eigen::Vector2d(0.5, first ? 1.0 : 0.3).cwiseProduct(standard.col(i).head<2>());
    const Eigen::Vector2d noise(0.4 + 0.5 * (i % 2), 0.3 + 0.2 * (i % 5));
    x += noise.cwiseProduct(standard.col(i).tail<2>());
    seen.push_back({x, noise.cwiseAbs2().asDiagonal()});
  }
  return seen;
}

TEST(Deconvolution, RecoversAPlantedMixture) {
  const NormalMixture found = Deconvolve(Planted(1500, 4.0), 2);
  ASSERT_EQ(found.size(), 2);
  const int first = found.components[0].mean.x() < found.components[1].mean.x() ? 0 : 1;
  EXPECT_NEAR(found.weights[first], 2.0 / 3, 0.04);
  const NormalDistribution &a = found.components[first], &b = found.components[1 - first];
  EXPECT_LT((a.mean - Eigen::Vector2d(0, 0)).norm(), 0.15);
  EXPECT_LT((b.mean - Eigen::Vector2d(4, 1)).norm(), 0.15);
  // Without the noise, whose variance is up to 0.81 and 1.21.
  EXPECT_NEAR(std::sqrt(a.covariance(0, 0)), 0.5, 0.1);
  EXPECT_NEAR(std::sqrt(a.covariance(1, 1)), 1.0, 0.1);
  EXPECT_NEAR(std::sqrt(b.covariance(1, 1)), 0.3, 0.15);
}

TEST(Deconvolution, ChoosesTheNumberOfComponents) {
  EXPECT_EQ(ChooseComponents(Planted(45, 8.0), 3).components, 2);
  std::vector<NormalDistribution> alike;
  for (const NormalDistribution& x : Planted(300, 1e3))
    if (x.mean.x() < 500 && alike.size() < 30) alike.push_back(x);
  const ComponentChoice one = ChooseComponents(alike, 4);
  EXPECT_EQ(one.components, 1);
  EXPECT_EQ(one.left_out.size(), 30u);
  EXPECT_EQ(one.log_likelihoods.size(), 4u);
}

// Far from all components the likelihood is small, and its logarithm finite.
TEST(Deconvolution, JudgesWhatIsFarAway) {
  const NormalMixture mixture = Deconvolve(Planted(50, 4.0), 2);
  const Eigen::Matrix2d exact = 1e-12 * Eigen::Matrix2d::Identity();
  const double near = mixture.LogLikelihood({Eigen::Vector2d(0, 0), exact});
  const double far = mixture.LogLikelihood({Eigen::Vector2d(1e4, 0), exact});
  EXPECT_TRUE(std::isfinite(far));
  EXPECT_LT(far, near - 1e6);
  EXPECT_GT(mixture.LogLikelihood({Eigen::Vector2d(1e4, 0), 1e8 * exact / 1e-12}), -100);
}

// Two observations in three directions still have a population.
TEST(Deconvolution, FewObservationsAreEnough) {
  const std::vector<NormalDistribution> two = {
      {Eigen::Vector3d(0, 0, 0), 0.01 * Eigen::Matrix3d::Identity()},
      {Eigen::Vector3d(1, 0, 0), 0.01 * Eigen::Matrix3d::Identity()}};
  const NormalMixture mixture = Deconvolve(two, 1);
  EXPECT_LT((mixture.components[0].mean - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-3);
  EXPECT_GT(mixture.components[0].covariance(1, 1), 1e-3);
  EXPECT_TRUE(std::isfinite(ChooseComponents(two, 4).log_likelihoods[0]));
}

TEST(Deconvolution, MomentsAreThoseOfTheWhole) {
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(1, 1);
  const NormalMixture mixture{
      {0.25, 0.75},
      {{Eigen::VectorXd::Constant(1, 0.0), unit}, {Eigen::VectorXd::Constant(1, 4.0), unit}}};
  EXPECT_NEAR(mixture.Moments().mean[0], 3.0, 1e-14);
  EXPECT_NEAR(mixture.Moments().covariance(0, 0), 1.0 + 0.25 * 9 + 0.75 * 1, 1e-14);
}

}  // namespace
}  // namespace drape::test
