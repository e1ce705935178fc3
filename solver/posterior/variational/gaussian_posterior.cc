// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/variational/gaussian_posterior.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

#include "physics/util/math/random.h"

namespace drape {

Eigen::MatrixXd GaussianPosterior::Draws(const Eigen::MatrixXd& standard) const {
  return (rotation * (factor * standard)).colwise() + mean;
}

Eigen::MatrixXd GaussianPosterior::Covariance() const {
  const Eigen::MatrixXd root = rotation * factor;
  return root * root.transpose();
}

Eigen::VectorXd GaussianPosterior::Deviations() const {
  return (rotation * factor).rowwise().norm();
}

double GaussianPosterior::DivergenceFromPrior() const {
  return 0.5 * (mean.squaredNorm() + factor.squaredNorm() - size()) -
         factor.diagonal().array().log().sum();
}

GaussianPosterior FromCovariance(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance) {
  CHECK_EQ(covariance.rows(), mean.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  return {mean, axes.eigenvectors(), axes.eigenvalues().cwiseSqrt().asDiagonal()};
}

Eigen::MatrixXd CovarianceRoot(const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(covariance);
  return axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd IndependentSamples(int size, int count, uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXd draws(size, count);
  for (double& value : draws.reshaped()) value = SampleNormal(random);
  return draws;
}

Eigen::MatrixXd BalancedSamples(int size, int count, uint64_t seed) {
  CHECK(count >= 2 && count % 2 == 0) << count;
  const int half = count / 2, exact = std::min(size, half);
  Eigen::MatrixXd draws = IndependentSamples(size, half, seed);
  auto leading = draws.topRows(exact);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> moments(leading * leading.transpose() /
                                                               half);
  leading = (moments.operatorInverseSqrt() * leading).eval();
  Eigen::MatrixXd pairs(size, count);
  pairs << draws, -draws;
  return pairs;
}

}  // namespace drape
