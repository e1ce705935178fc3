// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/distribution_metrics.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "losses/metrics/ensemble_scores.h"
#include "losses/metrics/metrics.h"

namespace drape {
namespace {

using Drapes = DistributionScorer::Drapes;

// The outlines [m] divided by √K, so that Euclidean distances are root mean squares.
Eigen::MatrixXd OutlineMatrix(const Drapes& drapes) {
  Eigen::MatrixXd outlines(kObservedAngles, drapes.size());
  for (size_t i = 0; i < drapes.size(); ++i)
    outlines.col(i) = drapes[i]->radius / std::sqrt(double(kObservedAngles));
  return outlines;
}

GrayImage ComputeMean(const Drapes& drapes) {
  MeanImage mean;
  for (const ObservedDrape* drape : drapes) mean.Add(drape->image);
  return mean.Mean();
}

void AddInterval(const std::vector<double>& samples, double probability, double observed,
                 IntervalSkill* sum) {
  const CentralInterval interval = ComputeInterval(samples, probability);
  sum->nominal += interval.nominal;
  sum->coverage += interval.Contains(observed);
  sum->width += interval.high - interval.low;
}

void Divide(double count, IntervalSkill* sum) {
  for (double* value : {&sum->nominal, &sum->coverage, &sum->width}) *value /= count;
}

}  // namespace

FeatureVector ComputeFeatures(const ShapeFeatures& shape) {
  return ListShapeFeatures(shape).head<kNumFeatures>();
}

Eigen::MatrixXd ComputeFeatures(const Drapes& drapes) {
  Eigen::MatrixXd features(kNumFeatures, drapes.size());
  for (size_t i = 0; i < drapes.size(); ++i) features.col(i) = ComputeFeatures(drapes[i]->shape);
  return features;
}

void DistributionScorer::AddFeature(int feature, const Eigen::VectorXd& samples, double observed) {
  FeatureScore& sum = sum_.features[feature];
  const double mean = samples.mean();
  const std::vector<double> values(samples.begin(), samples.end());
  sum.observed_mean += observed;
  sum.predicted_mean += mean;
  sum.predicted_sd += (samples.array() - mean).matrix().norm() / std::sqrt(samples.size() - 1.0);
  sum.crps += EnsembleCrps(values, observed);
  AddInterval(values, 0.5, observed, &sum.half);
  AddInterval(values, 0.9, observed, &sum.ninety);
}

void DistributionScorer::Add(const Drapes& samples, const Drapes& observed) {
  CHECK_GE(samples.size(), 2u);
  if (observed.empty()) return;
  const GrayImage mean = ComputeMean(samples);
  for (const ObservedDrape* drape : observed)
    sum_.mean_image_mse += MeanSquaredError(mean, drape->image);
  sum_.outline_energy += EnergyScores(OutlineMatrix(samples), OutlineMatrix(observed)).sum();
  SumFeatures(ComputeFeatures(samples), ComputeFeatures(observed));
}

void DistributionScorer::AddFeatures(const Eigen::MatrixXd& samples,
                                     const Eigen::MatrixXd& observed) {
  features_alone_ = true;
  SumFeatures(samples, observed);
}

void DistributionScorer::SumFeatures(const Eigen::MatrixXd& samples,
                                     const Eigen::MatrixXd& observed) {
  for (Eigen::Index i = 0; i < observed.cols(); ++i)
    for (int k = 0; k < kNumFeatures; ++k) AddFeature(k, samples.row(k), observed(k, i));
  const auto weights = scales_.cwiseInverse().asDiagonal();
  sum_.feature_energy += EnergyScores(weights * samples, weights * observed).sum();
  sum_.observed += static_cast<int>(observed.cols());
}

DistributionScore DistributionScorer::Score() const {
  CHECK_GT(sum_.observed, 0);
  DistributionScore score = sum_;
  const double count = sum_.observed;
  if (features_alone_)
    score.mean_image_mse = score.outline_energy = std::numeric_limits<double>::quiet_NaN();
  for (double* value : {&score.mean_image_mse, &score.feature_energy, &score.outline_energy})
    *value /= count;
  for (FeatureScore& feature : score.features) {
    for (double* value :
         {&feature.observed_mean, &feature.predicted_mean, &feature.predicted_sd, &feature.crps})
      *value /= count;
    Divide(count, &feature.half);
    Divide(count, &feature.ninety);
  }
  return score;
}

}  // namespace drape
