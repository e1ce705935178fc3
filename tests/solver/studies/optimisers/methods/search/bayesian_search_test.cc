// SPDX-License-Identifier: Apache-2.0
// Embeddings, acquisition functions and the search on functions whose minimum is known.
#include "solver/studies/optimisers/methods/search/bayesian_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "physics/util/math/random.h"
#include "solver/studies/optimisers/methods/search/acquisition.h"

namespace drape {
namespace {

constexpr double kHalfWidth = 3.0;
constexpr double kPi = std::numbers::pi;

using Function = std::function<std::optional<double>(const Eigen::VectorXd&)>;

// The least cost of so many evaluations.
double Minimise(SearchMethod& search, const Function& function, int evaluations) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < evaluations; ++i) {
    const Eigen::VectorXd theta = search.Propose();
    EXPECT_LE(theta.cwiseAbs().maxCoeff(), kHalfWidth);
    if (i == 0) {
      EXPECT_EQ(theta.norm(), 0.0);
    }
    const std::optional<double> cost = function(theta);
    if (cost) least = std::min(least, *cost);
    search.Report(cost);
  }
  return least;
}

// Branin's function (1972) over its usual box, stretched to |θ| ≤ 3: three minima of 0.397887, and
// 24.1 at θ = 0.
double Branin(const Eigen::VectorXd& theta) {
  const double x = 2.5 + 2.5 * theta[0], y = 7.5 + 2.5 * theta[1];
  const double valley = y - 5.1 / (4.0 * kPi * kPi) * x * x + 5.0 / kPi * x - 6.0;
  return valley * valley + 10.0 * (1.0 - 1.0 / (8.0 * kPi)) * std::cos(x) + 10.0;
}

TEST(Embedding, HashingHasOneSignInEachRowAndNeverClips) {
  std::mt19937_64 random(1);
  for (const int dimension : {2, 4, 8}) {
    const Embedding embedding = MakeHashingEmbedding(39, dimension, random);
    EXPECT_EQ(embedding.box, 1.0);
    EXPECT_EQ(embedding.matrix.cwiseAbs().rowwise().sum(), Eigen::VectorXd::Ones(39));
    EXPECT_EQ(embedding.matrix.cwiseAbs().rowwise().maxCoeff(), Eigen::VectorXd::Ones(39));
    EXPECT_LT(embedding.matrix.minCoeff(), 0.0);
    EXPECT_GT(embedding.matrix.maxCoeff(), 0.0);
    for (const Eigen::VectorXd& y :
         {Eigen::VectorXd::Ones(dimension).eval(), Eigen::VectorXd::Random(dimension).eval()})
      EXPECT_EQ(embedding.Map(y), embedding.matrix * y);
  }
}

// Each number of the small box drives a share 1/d of the large one.
TEST(Embedding, HashingIsUniform) {
  std::mt19937_64 random(2);
  const Embedding embedding = MakeHashingEmbedding(8000, 4, random);
  EXPECT_LT((embedding.matrix.cwiseAbs().colwise().sum().array() - 2000.0).abs().maxCoeff(), 160.0);
  EXPECT_LT(std::abs(embedding.matrix.sum()), 360.0);  // four standard deviations each
}

TEST(Embedding, GaussianIsStandardNormalAndClips) {
  std::mt19937_64 random(3);
  const Embedding embedding = MakeGaussianEmbedding(2000, 4, random);
  EXPECT_EQ(embedding.box, 2.0);
  EXPECT_NEAR(embedding.matrix.mean(), 0.0, 0.05);
  EXPECT_NEAR(embedding.matrix.squaredNorm() / 8000.0, 1.0, 0.07);
  const Eigen::VectorXd y = Eigen::VectorXd::Constant(4, 1.0), x = embedding.Map(y);
  int clipped = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double linear = embedding.matrix.row(i).dot(y);
    EXPECT_EQ(x[i], std::clamp(linear, -1.0, 1.0));
    clipped += std::abs(linear) > 1.0;
  }
  EXPECT_NEAR(clipped / 2000.0, std::erfc(0.5 / std::numbers::sqrt2), 0.05);
}

TEST(Acquisition, ExpectedImprovementIsTheIntegralOverTheNormalDistribution) {
  constexpr double kMean = 0.3, kDeviation = 0.8, kLeast = -0.1;
  constexpr int kSteps = 200000;
  double integral = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double z = 8.0 * (2.0 * (i + 0.5) / kSteps - 1.0);
    integral += std::max(kLeast - (kMean + kDeviation * z), 0.0) * std::exp(-0.5 * z * z) *
                (16.0 / kSteps) / std::sqrt(2.0 * kPi);
  }
  EXPECT_NEAR(ExpectedImprovement(kMean, kDeviation, kLeast), integral, 1e-9);
  EXPECT_EQ(ExpectedImprovement(0.2, 0.0, 0.5), 0.3);
  EXPECT_EQ(ExpectedImprovement(0.7, 0.0, 0.5), 0.0);
}

TEST(Acquisition, UpperConfidenceBoundIsThatOfThePublishedCode) {
  EXPECT_NEAR(UpperConfidenceBound(-1.5, 0.5, 7, 4),
              1.5 + 0.5 * std::sqrt(2.0 * std::log(std::pow(7.0, 4.0) * kPi * kPi / 0.3)), 1e-12);
}

TEST(LatinHypercube, HasOnePointInEachInterval) {
  std::mt19937_64 random(4);
  const Eigen::MatrixXd points = SampleLatinHypercube(3, 50, random);
  for (Eigen::Index row = 0; row < 3; ++row) {
    std::vector<int> intervals;
    for (const double x : points.row(row))
      intervals.push_back(static_cast<int>((x + 1.0) / 2.0 * 50.0));
    EXPECT_FALSE(std::is_sorted(intervals.begin(), intervals.end()));
    std::sort(intervals.begin(), intervals.end());
    for (int i = 0; i < 50; ++i) EXPECT_EQ(intervals[i], i);
  }
}

TEST(BayesianSearch, FindsAMinimumOfBraninIn60Evaluations) {
  for (const uint64_t seed : {1, 2, 3}) {
    BayesianSearch search(MakeIdentityEmbedding(2), kHalfWidth, {}, seed);
    EXPECT_LT(Minimise(search, Branin, 60), 0.42) << seed;
  }
}

// The process models the logarithm of the cost: here a tenth of Branin's function.
TEST(BayesianSearch, TheBoundOfConfidenceFindsAMinimumIn60Evaluations) {
  BayesianSearchOptions options;
  options.kernel = Kernel::kSquaredExponential;
  options.acquisition = BayesianSearchOptions::Acquisition::kUpperConfidenceBound;
  options.initial_points = 1;
  options.initial_variance = 1e-6;
  const auto smooth = [](const Eigen::VectorXd& theta) { return std::exp(0.1 * Branin(theta)); };
  for (const uint64_t seed : {1, 2, 3}) {
    BayesianSearch search(MakeIdentityEmbedding(2), kHalfWidth, options, seed);
    EXPECT_LT(10.0 * std::log(Minimise(search, smooth, 60)), 0.41) << seed;
  }
}

// A minimum that an embedding of four numbers reaches among 39; a Latin hypercube of 80 points
// comes to within 0.08 to 0.33.
TEST(BayesianSearch, FindsAMinimumThroughAnEmbedding) {
  std::mt19937_64 random(5);
  const Embedding embedding = MakeHashingEmbedding(39, 4, random);
  const Eigen::VectorXd minimum = kHalfWidth * embedding.Map(Eigen::Vector4d(0.5, -0.4, 0.3, -0.6));
  const auto bowl = [&](const Eigen::VectorXd& theta) { return (theta - minimum).squaredNorm(); };
  BayesianSearch search(embedding, kHalfWidth, {}, 6);
  EXPECT_LT(Minimise(search, bowl, 60), 0.05 * minimum.squaredNorm());
}

// The minimum is at the border of a half in which nothing can be evaluated.
TEST(BayesianSearch, FindsAMinimumBesidePointsThatFail) {
  const auto bowl = [](const Eigen::VectorXd& theta) -> std::optional<double> {
    if (theta[0] > 1.0) return std::nullopt;
    return (theta - Eigen::Vector2d(1.2, -1.0)).squaredNorm();
  };
  BayesianSearch search(MakeIdentityEmbedding(2), kHalfWidth, {}, 1);
  EXPECT_LT(Minimise(search, bowl, 50), 0.12);  // 0.04 at the border, 2.44 at the start
}

TEST(BayesianSearch, LivesWithAConstantAndWithNothingAtAll) {
  BayesianSearch flat(MakeIdentityEmbedding(2), kHalfWidth, {}, 8);
  EXPECT_EQ(Minimise(
                flat, [](const auto&) { return 5.0; }, 30),
            5.0);
  BayesianSearch nothing(MakeIdentityEmbedding(2), kHalfWidth, {}, 9);
  EXPECT_TRUE(std::isinf(Minimise(
      nothing, [](const auto&) { return std::nullopt; }, 30)));
}

TEST(BayesianSearch, DependsOnItsSeedAlone) {
  const auto last = [](uint64_t seed) {
    BayesianSearch search(MakeIdentityEmbedding(2), kHalfWidth, {}, seed);
    Minimise(search, Branin, 20);
    return search.Propose();
  };
  EXPECT_EQ(last(1), last(1));
  EXPECT_NE(last(1), last(2));
}

}  // namespace
}  // namespace drape
