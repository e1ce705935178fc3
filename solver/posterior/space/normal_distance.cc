// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/normal_distance.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace drape {
namespace {

using Axes = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

double LogDeterminant(const Eigen::LLT<Eigen::MatrixXd>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

double SquaredLength(const Eigen::LLT<Eigen::MatrixXd>& factor, const Eigen::VectorXd& x) {
  return factor.matrixL().solve(x).squaredNorm();
}

// Of a matrix without negative eigenvalues but for rounding.
Eigen::MatrixXd SquareRoot(const Eigen::MatrixXd& matrix) {
  const Axes axes(matrix);
  return axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         axes.eigenvectors().transpose();
}

}  // namespace

double LogDensity(const NormalDistribution& p, const Eigen::VectorXd& x) {
  const Eigen::LLT<Eigen::MatrixXd> factor(p.covariance);
  return -0.5 * (SquaredLength(factor, x - p.mean) + LogDeterminant(factor) +
                 p.size() * std::log(2 * std::numbers::pi));
}

double KullbackLeibler(const NormalDistribution& p, const NormalDistribution& q) {
  CHECK_EQ(p.size(), q.size());
  const Eigen::LLT<Eigen::MatrixXd> of_p(p.covariance), of_q(q.covariance);
  const double trace = of_q.solve(p.covariance).trace();
  return 0.5 * (trace + SquaredLength(of_q, q.mean - p.mean) - p.size() + LogDeterminant(of_q) -
                LogDeterminant(of_p));
}

double Bhattacharyya(const NormalDistribution& p, const NormalDistribution& q) {
  CHECK_EQ(p.size(), q.size());
  const Eigen::LLT<Eigen::MatrixXd> of_p(p.covariance), of_q(q.covariance),
      middle(0.5 * (p.covariance + q.covariance));
  return 0.125 * SquaredLength(middle, q.mean - p.mean) +
         0.5 * (LogDeterminant(middle) - 0.5 * (LogDeterminant(of_p) + LogDeterminant(of_q)));
}

double Hellinger(const NormalDistribution& p, const NormalDistribution& q) {
  return std::sqrt(std::max(0.0, -std::expm1(-Bhattacharyya(p, q))));
}

double Wasserstein(const NormalDistribution& p, const NormalDistribution& q) {
  CHECK_EQ(p.size(), q.size());
  const Eigen::MatrixXd root = SquareRoot(p.covariance);
  const double cross = SquareRoot(root * q.covariance * root).trace();
  const double spread = p.covariance.trace() + q.covariance.trace() - 2.0 * cross;
  return std::sqrt(std::max(0.0, (p.mean - q.mean).squaredNorm() + spread));
}

NormalDistribution Project(const NormalDistribution& p, const Eigen::MatrixXd& axes) {
  return {axes.transpose() * p.mean, axes.transpose() * p.covariance * axes};
}

DeterminedDirections FindDetermined(const Eigen::MatrixXd& covariance, int count, double most) {
  const Axes axes(covariance);
  const Eigen::Index below = (axes.eigenvalues().array() < most).count();
  const Eigen::Index kept = std::min<Eigen::Index>(below, count);
  return {axes.eigenvectors().leftCols(kept), axes.eigenvalues().head(kept)};
}

NormalDistribution WithoutPrior(const NormalDistribution& posterior,
                                const Eigen::VectorXd& centre) {
  const Axes axes(posterior.covariance);
  const Eigen::MatrixXd& v = axes.eigenvectors();
  const Eigen::ArrayXd s = axes.eigenvalues().array().max(0.0).min(kMostNoise / (1 + kMostNoise));
  const Eigen::ArrayXd mean = (v.transpose() * posterior.mean).array();
  const Eigen::ArrayXd prior = (v.transpose() * centre).array();
  return {v * ((mean - s * prior) / (1 - s)).matrix(),
          v * (s / (1 - s)).matrix().asDiagonal() * v.transpose()};
}

}  // namespace drape
