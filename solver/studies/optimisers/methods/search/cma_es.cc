// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/search/cma_es.h"

#include <glog/logging.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "physics/util/math/random.h"

namespace drape {

// Names are those of [Hansen 2016, appendix A].
CmaEs::CmaEs(int size, double bound, double step_size, uint64_t seed)
    : size_(size),
      bound_(bound),
      lambda_(4 + static_cast<int>(3.0 * std::log(static_cast<double>(size)))),
      random_(seed),
      mean_(Eigen::VectorXd::Zero(size)),
      path_sigma_(mean_),
      path_c_(mean_),
      covariance_(Eigen::MatrixXd::Identity(size, size)),
      axes_(covariance_),
      deviations_(Eigen::VectorXd::Ones(size)),
      step_size_(step_size) {
  CHECK_GT(bound, 0.0);
  CHECK_GT(step_size, 0.0);
  const double n = size;
  weights_.resize(lambda_ / 2);
  for (Eigen::Index i = 0; i < weights_.size(); ++i)
    weights_[i] = std::log(0.5 * (lambda_ + 1.0)) - std::log(static_cast<double>(i) + 1.0);
  weights_ /= weights_.sum();
  mu_eff_ = 1.0 / weights_.squaredNorm();
  c_sigma_ = (mu_eff_ + 2.0) / (n + mu_eff_ + 5.0);
  d_sigma_ = 1.0 + 2.0 * std::max(0.0, std::sqrt((mu_eff_ - 1.0) / (n + 1.0)) - 1.0) + c_sigma_;
  c_c_ = (4.0 + mu_eff_ / n) / (n + 4.0 + 2.0 * mu_eff_ / n);
  c_1_ = 2.0 / ((n + 1.3) * (n + 1.3) + mu_eff_);
  c_mu_ = std::min(
      1.0 - c_1_, 2.0 * (0.25 + mu_eff_ + 1.0 / mu_eff_ - 2.0) / ((n + 2.0) * (n + 2.0) + mu_eff_));
  chi_ = std::sqrt(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));  // E|N(0, 1)|
}

Eigen::VectorXd CmaEs::Propose() {
  CHECK_EQ(samples_.size(), costs_.size()) << "a point without its cost";
  if (!started_) return mean_;
  samples_.push_back(Sample());
  return samples_.back();
}

void CmaEs::Report(std::optional<double> cost) {
  if (!started_) {
    started_ = true;
    return;
  }
  CHECK_EQ(samples_.size(), costs_.size() + 1) << "a cost without its point";
  costs_.push_back(cost.value_or(std::numeric_limits<double>::infinity()));
  if (static_cast<int>(costs_.size()) < lambda_) return;
  Update();
  samples_.clear();
  costs_.clear();
}

Eigen::VectorXd CmaEs::Sample() {
  constexpr int kTrials = 10;
  Eigen::VectorXd sample(size_);
  for (int trial = 0; trial < kTrials; ++trial) {
    Eigen::VectorXd normal(size_);
    for (double& entry : normal) entry = SampleNormal(random_);
    sample = mean_ + step_size_ * (axes_ * deviations_.cwiseProduct(normal));
    if (sample.cwiseAbs().maxCoeff() <= bound_) return sample;
  }
  return sample.cwiseMax(-bound_).cwiseMin(bound_);
}

void CmaEs::Update() {
  std::vector<int> order(lambda_);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return costs_[a] < costs_[b]; });
  if (!std::isfinite(costs_[order.front()])) {
    step_size_ *= 0.5;
    return;
  }
  ++generation_;
  Eigen::MatrixXd steps(size_, weights_.size());  // y of the best
  for (Eigen::Index i = 0; i < steps.cols(); ++i)
    steps.col(i) = (samples_[order[i]] - mean_) / step_size_;
  const Eigen::VectorXd step = steps * weights_;
  mean_ += step_size_ * step;
  const Eigen::VectorXd whitened =
      axes_ * (axes_.transpose() * step).cwiseQuotient(deviations_);  // C^(−1/2)·step
  path_sigma_ =
      (1.0 - c_sigma_) * path_sigma_ + std::sqrt(c_sigma_ * (2.0 - c_sigma_) * mu_eff_) * whitened;
  const double length = path_sigma_.norm();
  const double steady = std::sqrt(1.0 - std::pow(1.0 - c_sigma_, 2.0 * generation_));
  const bool moves = length / steady < (1.4 + 2.0 / (size_ + 1.0)) * chi_;  // h_σ
  path_c_ *= 1.0 - c_c_;
  if (moves) path_c_ += std::sqrt(c_c_ * (2.0 - c_c_) * mu_eff_) * step;
  const double forgotten = moves ? 0.0 : c_1_ * c_c_ * (2.0 - c_c_);
  covariance_ = (1.0 + forgotten - c_1_ - c_mu_) * covariance_ +
                c_1_ * path_c_ * path_c_.transpose() +
                c_mu_ * steps * weights_.asDiagonal() * steps.transpose();
  step_size_ *= std::exp(c_sigma_ / d_sigma_ * (length / chi_ - 1.0));
  Decompose();
}

void CmaEs::Decompose() {
  constexpr double kLeastDeviation = 1e-9, kLargestCondition = 1e14;
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance_);
  const Eigen::VectorXd& values = eigen.eigenvalues();  // ascending
  if (!(values[0] > 0.0) || values[size_ - 1] > kLargestCondition * values[0]) {
    converged_ = true;
    return;
  }
  axes_ = eigen.eigenvectors();
  deviations_ = values.cwiseSqrt();
  converged_ = step_size_ * deviations_.maxCoeff() < kLeastDeviation;
}

}  // namespace drape
