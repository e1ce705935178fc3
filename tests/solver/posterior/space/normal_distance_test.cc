// SPDX-License-Identifier: Apache-2.0
// Distances of normal distributions against closed forms and Monte Carlo [METHODS, P60].
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

#include "physics/util/math/random.h"
#include "solver/posterior/space/normal_mixture.h"
#include "solver/posterior/variational_fit.h"

namespace drape::test {
namespace {

NormalDistribution OneNumber(double mean, double sd) {
  return {Eigen::VectorXd::Constant(1, mean), Eigen::MatrixXd::Constant(1, 1, sd * sd)};
}

NormalDistribution RandomNormal(int size, int seed) {
  const Eigen::MatrixXd numbers = IndependentSamples(size, size + 1, seed);
  const Eigen::MatrixXd root = numbers.leftCols(size);
  return {numbers.col(size), root * root.transpose() + Eigen::MatrixXd::Identity(size, size)};
}

// By samples of p: mean and standard error of f.
template <class F>
std::pair<double, double> Sample(const NormalDistribution& p, const F& f) {
  constexpr int kSamples = 40000;
  const Eigen::MatrixXd root = p.covariance.llt().matrixL();
  const Eigen::MatrixXd standard = IndependentSamples(p.size(), kSamples, 5);
  Eigen::ArrayXd values(kSamples);
  for (int i = 0; i < kSamples; ++i) values[i] = f(p.mean + root * standard.col(i));
  const double mean = values.mean();
  return {mean, std::sqrt((values - mean).square().mean() / kSamples)};
}

TEST(NormalDistance, IsThatOfTheTextbookForOneNumber) {
  const NormalDistribution p = OneNumber(1.0, 2.0), q = OneNumber(-0.5, 3.0);
  EXPECT_NEAR(KullbackLeibler(p, q), std::log(1.5) + (4 + 2.25) / 18 - 0.5, 1e-14);
  const double overlap = std::sqrt(2 * 2.0 * 3.0 / 13.0) * std::exp(-0.25 * 2.25 / 13.0);
  EXPECT_NEAR(Bhattacharyya(p, q), -std::log(overlap), 1e-14);
  EXPECT_NEAR(Hellinger(p, q), std::sqrt(1 - overlap), 1e-14);
  EXPECT_NEAR(Wasserstein(p, q), std::hypot(1.5, 1.0), 1e-14);
  EXPECT_NEAR(LogDensity(p, Eigen::VectorXd::Constant(1, 3.0)),
              -0.5 - std::log(2 * std::sqrt(2 * std::numbers::pi)), 1e-14);
}

TEST(NormalDistance, AgreesWithMonteCarlo) {
  const NormalDistribution p = RandomNormal(4, 1), q = RandomNormal(4, 2);
  const auto [divergence, error] =
      Sample(p, [&](const Eigen::VectorXd& x) { return LogDensity(p, x) - LogDensity(q, x); });
  EXPECT_NEAR(KullbackLeibler(p, q), divergence, 4 * error);
  EXPECT_LT(error, 0.02 * divergence);
  const auto [overlap, overlap_error] = Sample(p, [&](const Eigen::VectorXd& x) {
    return std::exp(0.5 * (LogDensity(q, x) - LogDensity(p, x)));
  });
  EXPECT_NEAR(std::exp(-Bhattacharyya(p, q)), overlap, 4 * overlap_error);
}

// All but Wasserstein's are invariant under an affine map; that one under a rotation.
TEST(NormalDistance, DoesNotDependOnTheCoordinates) {
  const NormalDistribution p = RandomNormal(3, 3), q = RandomNormal(3, 4);
  const Eigen::MatrixXd map = IndependentSamples(3, 3, 6);
  const auto moved = [](const Eigen::MatrixXd& a, NormalDistribution n) {
    return NormalDistribution{a * n.mean + Eigen::Vector3d(1, 2, 3),
                              a * n.covariance * a.transpose()};
  };
  EXPECT_NEAR(KullbackLeibler(moved(map, p), moved(map, q)), KullbackLeibler(p, q), 1e-9);
  EXPECT_NEAR(Hellinger(moved(map, p), moved(map, q)), Hellinger(p, q), 1e-10);
  const Eigen::MatrixXd turn = Eigen::Quaterniond(1, 2, 3, 4).normalized().toRotationMatrix();
  EXPECT_NEAR(Wasserstein(moved(turn, p), moved(turn, q)), Wasserstein(p, q), 1e-12);
  EXPECT_NEAR(Wasserstein(p, p), 0.0, 1e-6);
}

TEST(NormalDistance, FindsWhatTheDataDetermine) {
  Eigen::MatrixXd covariance = Eigen::Vector4d(0.9, 0.04, 0.2, 1.0).asDiagonal();
  const Eigen::MatrixXd turn = RandomNormal(4, 7).covariance.householderQr().householderQ();
  covariance = (turn * covariance * turn.transpose()).eval();
  const DeterminedDirections two = FindDetermined(covariance, 4);
  ASSERT_EQ(two.ratios.size(), 2);
  EXPECT_NEAR(two.ratios[0], 0.04, 1e-12);
  EXPECT_NEAR(std::abs(two.axes.col(0).dot(turn.col(1))), 1.0, 1e-12);
  EXPECT_EQ(FindDetermined(covariance, 1).ratios.size(), 1);
}

// Bayes' rule with the likelihood that is found gives the posterior again.
TEST(NormalDistance, TakesThePriorOut) {
  const NormalDistribution seen = RandomNormal(3, 8);
  const Eigen::Vector3d centre(0.3, -1, 2);
  const Eigen::MatrixXd precision = seen.covariance.inverse() + Eigen::MatrixXd::Identity(3, 3);
  NormalDistribution posterior{Eigen::VectorXd(), precision.inverse()};
  posterior.mean = posterior.covariance * (seen.covariance.inverse() * seen.mean + centre);
  const NormalDistribution found = WithoutPrior(posterior, centre);
  EXPECT_LT((found.mean - seen.mean).norm(), 1e-10);
  EXPECT_LT((found.covariance - seen.covariance).norm(), 1e-10);
  // Nothing was seen: as uncertain as can be said.
  const NormalDistribution none = WithoutPrior({centre, Eigen::MatrixXd::Identity(3, 3)}, centre);
  EXPECT_NEAR(none.covariance(0, 0), kMostNoise, 1e-6 * kMostNoise);
}

}  // namespace
}  // namespace drape::test
