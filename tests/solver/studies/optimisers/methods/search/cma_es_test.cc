// SPDX-License-Identifier: Apache-2.0
// The evolution strategy on functions whose minimum is known.
#include "solver/studies/optimisers/methods/search/cma_es.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr double kBound = 3.0, kStepSize = 1.0;

using Function = std::function<std::optional<double>(const Eigen::VectorXd&)>;

// Evaluations until the cost is at most `target`; most + 1 when it never is.
int CountEvaluations(CmaEs& search, const Function& function, double target, int most) {
  for (int i = 1; i <= most; ++i) {
    const Eigen::VectorXd theta = search.Propose();
    EXPECT_LE(theta.cwiseAbs().maxCoeff(), kBound);
    if (i == 1) {
      EXPECT_EQ(theta.norm(), 0.0);
    }
    const std::optional<double> cost = function(theta);
    if (cost && *cost <= target) return i;
    search.Report(cost);
  }
  return most + 1;
}

double Bowl(const Eigen::VectorXd& theta) { return (theta.array() - 1.0).square().sum(); }

TEST(CmaEs, FindsTheMinimumOfABowlIn800Evaluations) {
  for (const uint64_t seed : {1, 2, 3}) {
    CmaEs search(7, kBound, kStepSize, seed);
    EXPECT_LE(CountEvaluations(search, Bowl, 1e-6, 800), 800) << seed;
  }
}

// Squared axes from 1 to 10⁶ in random directions: only an adapted covariance gets there.
TEST(CmaEs, FindsTheMinimumOfARotatedEllipsoidIn4500Evaluations) {
  std::mt19937_64 random(1);
  Eigen::MatrixXd normal(7, 7);
  for (double& entry : normal.reshaped()) entry = SampleNormal(random);
  const Eigen::MatrixXd rotation = normal.householderQr().householderQ();
  const auto ellipsoid = [&](const Eigen::VectorXd& theta) {
    const Eigen::VectorXd x = rotation * (theta.array() - 0.5).matrix();
    double cost = 0.0;
    for (int i = 0; i < 7; ++i) cost += std::pow(10.0, i) * x[i] * x[i];
    return cost;
  };
  CmaEs search(7, kBound, kStepSize, 2);
  EXPECT_LE(CountEvaluations(search, ellipsoid, 1e-8, 4500), 4500);
}

TEST(CmaEs, FollowsRosenbrocksValleyIn2000Evaluations) {
  const auto valley = [](const Eigen::VectorXd& theta) {
    return 100.0 * std::pow(theta[1] - theta[0] * theta[0], 2) + std::pow(1.0 - theta[0], 2);
  };
  CmaEs search(2, kBound, kStepSize, 3);
  EXPECT_LE(CountEvaluations(search, valley, 1e-8, 2000), 2000);
}

TEST(CmaEs, FindsAMinimumAtTheBorderOfThePointsThatFail) {
  const auto half = [](const Eigen::VectorXd& theta) -> std::optional<double> {
    if (theta[0] > 0.8) return std::nullopt;
    return Bowl(theta);
  };
  CmaEs search(3, kBound, kStepSize, 4);
  EXPECT_LE(CountEvaluations(search, half, 0.0401, 1500), 1500);  // 0.04 at the border
}

TEST(CmaEs, TakesSmallerStepsWhereEverythingFails) {
  CmaEs search(3, kBound, kStepSize, 5);
  CountEvaluations(
      search, [](const auto&) { return std::nullopt; }, 0.0, 100);
  EXPECT_LT(search.step_size(), 1e-3);
}

// Steps far longer than the box.
TEST(CmaEs, StaysInTheBox) {
  CmaEs search(5, kBound, 50.0, 7);
  EXPECT_EQ(CountEvaluations(search, Bowl, 0.0, 100), 101);
}

TEST(CmaEs, SaysWhenItHasConverged) {
  CmaEs search(3, kBound, kStepSize, 6);
  int evaluations = 0;
  for (; evaluations < 5000 && !search.converged(); ++evaluations)
    search.Report(Bowl(search.Propose()));
  EXPECT_GT(evaluations, 200);
  EXPECT_LT(evaluations, 3000);
}

TEST(CmaEs, DependsOnItsSeedAlone) {
  const auto last = [](uint64_t seed) {
    CmaEs search(5, kBound, kStepSize, seed);
    CountEvaluations(search, Bowl, 0.0, 200);
    return search.Propose();
  };
  EXPECT_EQ(last(1), last(1));
  EXPECT_NE(last(1), last(2));
}

}  // namespace
}  // namespace drape
