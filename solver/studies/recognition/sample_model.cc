// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/sample_model.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>

namespace drape {
namespace {

constexpr int kIterations = 60;

Eigen::MatrixXd Inverse(const Eigen::MatrixXd& matrix) {
  return matrix.llt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

}  // namespace

SampleModel::SampleModel(const std::vector<SeenSample>& samples, int fabrics,
                         const Eigen::VectorXd& scale) {
  CHECK(!samples.empty());
  const Eigen::Index d = scale.size();
  const Eigen::MatrixXd shrink = scale.cwiseAbs2().asDiagonal();
  population_ = {Eigen::VectorXd::Zero(d), 10.0 * shrink};
  for (const SeenSample& sample : samples)
    population_.mean += sample.seen.mean / double(samples.size());
  within_ = shrink;
  fabrics_.resize(fabrics);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    FindFabrics(samples);
    Eigen::MatrixXd within = shrink;
    for (const SeenSample& sample : samples) {
      const NormalDistribution& fabric = fabrics_[sample.fabric];
      const Eigen::MatrixXd gain = within_ * Inverse(within_ + sample.seen.covariance);
      const Eigen::VectorXd off = sample.seen.mean - fabric.mean;
      within += gain * (off * off.transpose() + fabric.covariance) * gain.transpose() + within_ -
                gain * within_;
    }
    NormalDistribution next{Eigen::VectorXd::Zero(d), shrink};
    for (const NormalDistribution& fabric : fabrics_) next.mean += fabric.mean / double(fabrics);
    for (const NormalDistribution& fabric : fabrics_) {
      const Eigen::VectorXd off = fabric.mean - next.mean;
      next.covariance += fabric.covariance + off * off.transpose();
    }
    next.covariance /= fabrics + 1.0;
    within_ = within / (double(samples.size()) + 1.0);
    within_ = 0.5 * (within_ + within_.transpose()).eval();
    population_ = next;
  }
  FindFabrics(samples);
}

void SampleModel::FindFabrics(const std::vector<SeenSample>& samples) {
  const Eigen::MatrixXd prior = Inverse(population_.covariance);
  std::vector<Eigen::MatrixXd> precision(fabrics_.size(), prior);
  std::vector<Eigen::VectorXd> pull(fabrics_.size(), prior * population_.mean);
  for (const SeenSample& sample : samples) {
    const Eigen::MatrixXd one = Inverse(within_ + sample.seen.covariance);
    precision[sample.fabric] += one;
    pull[sample.fabric] += one * sample.seen.mean;
  }
  for (std::size_t f = 0; f < fabrics_.size(); ++f) {
    fabrics_[f].covariance = Inverse(precision[f]);
    fabrics_[f].mean = fabrics_[f].covariance * pull[f];
  }
}

Eigen::VectorXd SampleModel::LogLikelihoods(const NormalDistribution& seen) const {
  Eigen::VectorXd logs(fabrics_.size());
  for (std::size_t f = 0; f < fabrics_.size(); ++f)
    logs[Eigen::Index(f)] = LogDensity(
        {fabrics_[f].mean, fabrics_[f].covariance + within_ + seen.covariance}, seen.mean);
  return logs;
}

std::vector<Eigen::VectorXd> CompareWithOthers(const std::vector<SeenSample>& samples, int fabrics,
                                               const Eigen::VectorXd& scale) {
  std::vector<Eigen::VectorXd> logs;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    std::vector<SeenSample> others = samples;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    logs.push_back(SampleModel(others, fabrics, scale).LogLikelihoods(samples[i].seen));
  }
  return logs;
}

}  // namespace drape
