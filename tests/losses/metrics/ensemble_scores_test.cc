// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "losses/metrics/metrics.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

std::vector<double> Normals(int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<double> draws(count);
  for (double& draw : draws) draw = SampleNormal(random);
  return draws;
}

// The score of a standard normal distribution [Gneiting 2007, eq. 21].
double NormalCrps(double z) {
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI);
  const double below = 0.5 * std::erfc(-z / std::sqrt(2.0));
  return z * (2 * below - 1) + 2 * density - 1 / std::sqrt(M_PI);
}

TEST(EnsembleCrps, OfTwoSamplesByHand) {
  EXPECT_NEAR(EnsembleCrps({4, 1}, 2), (1 + 2) / 2.0 - 3 / 2.0, 1e-15);
  EXPECT_NEAR(EnsembleCrps({1, 1, 1}, 3), 2, 1e-15);
}

TEST(EnsembleCrps, ApproachesThatOfANormal) {
  const std::vector<double> draws = Normals(40000, 1);
  for (const double z : {-2.0, 0.0, 0.7}) EXPECT_NEAR(EnsembleCrps(draws, z), NormalCrps(z), 0.01);
}

// The mean over ensembles of three is that of the distribution; with m² instead of m(m−1) it would
// be larger by 1/(3·√π) = 0.19.
TEST(EnsembleCrps, IsFairToSmallEnsembles) {
  const std::vector<double> draws = Normals(60000, 2);
  double mean = 0;
  for (size_t i = 0; i < draws.size(); i += 3)
    mean += EnsembleCrps({draws[i], draws[i + 1], draws[i + 2]}, 0.5) / (draws.size() / 3);
  EXPECT_NEAR(mean, NormalCrps(0.5), 0.01);
}

TEST(EnergyScores, OfNumbersAreTheCrps) {
  const std::vector<double> draws = Normals(50, 3);
  const Eigen::MatrixXd row = Eigen::Map<const Eigen::RowVectorXd>(draws.data(), 50);
  const Eigen::VectorXd scores = EnergyScores(row, Eigen::RowVector2d(0.3, -1));
  EXPECT_NEAR(scores[0], EnsembleCrps(draws, 0.3), 1e-13);
  EXPECT_NEAR(scores[1], EnsembleCrps(draws, -1), 1e-13);
}

// In the plane, at the mean of a standard normal: E|X| − ½E|X − X'| = √(π/2)·(1 − 1/√2).
TEST(EnergyScores, AtTheMeanOfANormalInThePlane) {
  const std::vector<double> draws = Normals(12000, 4);
  const Eigen::MatrixXd plane = Eigen::Map<const Eigen::MatrixXd>(draws.data(), 2, 6000);
  EXPECT_NEAR(EnergyScores(plane, Eigen::Vector2d::Zero())[0],
              std::sqrt(M_PI / 2) * (1 - 1 / std::sqrt(2.0)), 0.01);
}

TEST(ComputeInterval, ExactQuantiles) {
  std::vector<double> draws(19);
  std::iota(draws.rbegin(), draws.rend(), 1.0);
  const CentralInterval ninety = ComputeInterval(draws, 0.9), half = ComputeInterval(draws, 0.5);
  EXPECT_NEAR(ninety.low, 1, 1e-12);
  EXPECT_NEAR(ninety.high, 19, 1e-12);
  EXPECT_NEAR(ninety.nominal, 0.9, 1e-12);
  EXPECT_NEAR(half.low, 5, 1e-12);
  EXPECT_NEAR(half.high, 15, 1e-12);
  EXPECT_TRUE(half.Contains(5.1));
  EXPECT_FALSE(half.Contains(15.1));
}

TEST(ComputeInterval, ReportsWhatFewSamplesCanReach) {
  const CentralInterval interval = ComputeInterval({1, 2, 3}, 0.9);
  EXPECT_EQ(interval.low, 1);
  EXPECT_EQ(interval.high, 3);
  EXPECT_NEAR(interval.nominal, 0.5, 1e-12);
}

// Another sample lies in the interval with the stated probability, for any number of samples.
TEST(ComputeInterval, CoversAnotherSampleAsOftenAsStated) {
  for (const int m : {4, 12, 40}) {
    const std::vector<double> all = Normals(3000 * (m + 1), 5);
    int inside = 0;
    double nominal = 0;
    for (int i = 0; i < 3000; ++i) {
      const auto begin = all.begin() + i * (m + 1);
      const CentralInterval interval = ComputeInterval({begin, begin + m}, 0.5);
      inside += interval.Contains(begin[m]);
      nominal = interval.nominal;
    }
    EXPECT_NEAR(inside / 3000.0, nominal, 0.03) << m;
  }
}

}  // namespace
}  // namespace drape
