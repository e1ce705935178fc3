// SPDX-License-Identifier: Apache-2.0
// The Gaussian process against closed forms, differences and itself.
#include "solver/studies/optimisers/methods/search/gaussian_process.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr double kSignal = 1.3, kNoise = 0.4;

// Lengths 0.5, 1, 1.5, …
Hyperparameters MakeHyperparameters(int dimension, double noise = kNoise) {
  Hyperparameters logs(dimension + 2);
  logs[0] = std::log(kSignal);
  for (int i = 0; i < dimension; ++i) logs[1 + i] = std::log(0.5 * (i + 1));
  logs[dimension + 1] = std::log(noise);
  return logs;
}

Eigen::MatrixXd RandomMatrix(int rows, int cols, uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd matrix(rows, cols);
  for (double& entry : matrix.reshaped()) entry = SampleNormal(random);
  return matrix;
}

// The covariance of two points by the definition of the kernels.
double ExpectedCovariance(Kernel kernel, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double square = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    square += std::pow((a[i] - b[i]) / (0.5 * (static_cast<double>(i) + 1.0)), 2);
  const double r = std::sqrt(5.0 * square);
  const double correlation = kernel == Kernel::kSquaredExponential
                                 ? std::exp(-0.5 * square)
                                 : (1.0 + r + 5.0 * square / 3.0) * std::exp(-r);
  return kSignal * kSignal * correlation;
}

class EachKernel : public testing::TestWithParam<Kernel> {
 protected:
  // Of the observations, by definition.
  Eigen::MatrixXd Covariance(const Eigen::MatrixXd& points) const {
    Eigen::MatrixXd covariance(points.cols(), points.cols());
    for (Eigen::Index i = 0; i < points.cols(); ++i)
      for (Eigen::Index j = 0; j < points.cols(); ++j)
        covariance(i, j) = ExpectedCovariance(GetParam(), points.col(i), points.col(j)) +
                           (i == j ? kNoise * kNoise + kNugget * kSignal * kSignal : 0.0);
    return covariance;
  }
};

TEST_P(EachKernel, PosteriorIsTheConditionalNormalDistribution) {
  const Eigen::MatrixXd points = RandomMatrix(2, 5, 1), at = RandomMatrix(2, 3, 2);
  const Eigen::VectorXd values = RandomMatrix(5, 1, 3);
  GaussianProcess process(GetParam(), MakeHyperparameters(2));
  ASSERT_TRUE(process.SetPoints(points));
  const GaussianProcess::Posterior posterior = process.Predict(values, at);
  const Eigen::MatrixXd inverse = Covariance(points).inverse();
  for (Eigen::Index i = 0; i < at.cols(); ++i) {
    Eigen::VectorXd cross(5);
    for (Eigen::Index j = 0; j < 5; ++j)
      cross[j] = ExpectedCovariance(GetParam(), points.col(j), at.col(i));
    EXPECT_NEAR(posterior.mean[i], cross.dot(inverse * values), 1e-12);
    EXPECT_NEAR(posterior.variance[i], kSignal * kSignal - cross.dot(inverse * cross), 1e-12);
  }
}

TEST_P(EachKernel, LikelihoodIsThatOfTheNormalDistribution) {
  const Eigen::MatrixXd points = RandomMatrix(3, 6, 4);
  const Eigen::VectorXd values = RandomMatrix(6, 1, 5);
  GaussianProcess process(GetParam(), MakeHyperparameters(3));
  ASSERT_TRUE(process.SetPoints(points));
  const Eigen::MatrixXd covariance = Covariance(points);
  const double expected = -0.5 * values.dot(covariance.inverse() * values) -
                          0.5 * std::log(covariance.determinant()) -
                          3.0 * std::log(2.0 * std::numbers::pi);
  EXPECT_NEAR(process.ComputeLikelihood(values, false).log, expected, 1e-11);
}

TEST_P(EachKernel, GradientOfTheLikelihoodIsThatOfDifferences) {
  constexpr double kStep = 1e-5;
  const Eigen::MatrixXd points = RandomMatrix(3, 12, 6);
  const Eigen::VectorXd values = RandomMatrix(12, 1, 7);
  const Hyperparameters here = MakeHyperparameters(3);
  const auto log_at = [&](const Hyperparameters& logs) {
    GaussianProcess process(GetParam(), logs);
    EXPECT_TRUE(process.SetPoints(points));
    return process.ComputeLikelihood(values, false).log;
  };
  GaussianProcess process(GetParam(), here);
  ASSERT_TRUE(process.SetPoints(points));
  const Eigen::VectorXd gradient = process.ComputeLikelihood(values, true).gradient;
  ASSERT_EQ(gradient.size(), 5);
  for (int i = 0; i < 5; ++i) {
    const Hyperparameters step = kStep * Hyperparameters::Unit(5, i);
    EXPECT_NEAR(gradient[i], (log_at(here + step) - log_at(here - step)) / (2.0 * kStep), 1e-7)
        << i;
  }
}

TEST_P(EachKernel, WithoutNoiseItPassesThroughTheValues) {
  const Eigen::MatrixXd points = RandomMatrix(2, 6, 8);
  const Eigen::VectorXd values = RandomMatrix(6, 1, 9);
  GaussianProcess process(GetParam(), MakeHyperparameters(2, 1e-6));
  ASSERT_TRUE(process.SetPoints(points));
  const GaussianProcess::Posterior posterior = process.Predict(values, points);
  EXPECT_LT((posterior.mean - values).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_LT(posterior.variance.maxCoeff(), 1e-6);
}

TEST_P(EachKernel, PointByPointIsTheSameAsAllAtOnce) {
  const Eigen::MatrixXd points = RandomMatrix(2, 9, 10), at = RandomMatrix(2, 4, 11);
  const Eigen::VectorXd values = RandomMatrix(9, 1, 12);
  GaussianProcess at_once(GetParam(), MakeHyperparameters(2)), grown = at_once;
  ASSERT_TRUE(at_once.SetPoints(points));
  for (Eigen::Index i = 0; i < points.cols(); ++i) ASSERT_TRUE(grown.Add(points.col(i)));
  EXPECT_EQ(grown.size(), 9);
  EXPECT_LT((grown.Predict(values, at).mean - at_once.Predict(values, at).mean).norm(), 1e-12);
  EXPECT_LT((grown.Predict(values, at).variance - at_once.Predict(values, at).variance).norm(),
            1e-12);
}

// Values of a sample of the process: the fit is more probable than what generated them, and no step
// from it increases the density.
TEST_P(EachKernel, FittedHyperparametersAreTheMostProbable) {
  const Hyperparameters generating = MakeHyperparameters(2);
  const Eigen::MatrixXd points = RandomMatrix(2, 60, 13);
  const Eigen::VectorXd values =
      Eigen::MatrixXd(Covariance(points).llt().matrixL()) * RandomMatrix(60, 1, 14);
  const Hyperparameters prior_mean = Hyperparameters::Constant(4, 0.2);
  const Hyperparameters fitted =
      FitHyperparameters(GetParam(), points, values, Hyperparameters::Zero(4), prior_mean, 100);
  const auto log_density = [&](const Hyperparameters& logs) {
    GaussianProcess process(GetParam(), logs);
    EXPECT_TRUE(process.SetPoints(points));
    return process.ComputeLikelihood(values, false).log -
           0.5 * (logs - prior_mean).squaredNorm() / (kHyperpriorSd * kHyperpriorSd);
  };
  EXPECT_GT(log_density(fitted), log_density(Hyperparameters::Zero(4)) + 1.0);
  EXPECT_GE(log_density(fitted), log_density(generating));
  for (int i = 0; i < 4; ++i)
    for (const double step : {-0.05, 0.05})
      EXPECT_GT(log_density(fitted), log_density(fitted + step * Hyperparameters::Unit(4, i))) << i;
}

// Where the density overflows, no step can be taken.
TEST_P(EachKernel, AHopelessStartIsKept) {
  const Eigen::MatrixXd points = RandomMatrix(2, 20, 15);
  const Eigen::VectorXd values = RandomMatrix(20, 1, 16);
  const Hyperparameters start = Hyperparameters::Constant(4, 1e44);
  EXPECT_EQ(FitHyperparameters(GetParam(), points, values, start, Hyperparameters::Zero(4), 20),
            start);
}

INSTANTIATE_TEST_SUITE_P(Both, EachKernel,
                         testing::Values(Kernel::kSquaredExponential, Kernel::kMatern52),
                         [](const auto& info) {
                           return info.param == Kernel::kMatern52 ? "Matern52"
                                                                  : "SquaredExponential";
                         });

}  // namespace
}  // namespace drape
