// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/distribution_metrics.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "losses/metrics/ensemble_scores.h"
#include "losses/metrics/metrics.h"

namespace drape {
namespace {

using Drapes = DistributionScorer::Drapes;

Eigen::MatrixXd FeatureMatrix(const Drapes& drapes) {
  Eigen::MatrixXd features(kNumFeatures, drapes.size());
  for (size_t i = 0; i < drapes.size(); ++i) features.col(i) = ComputeFeatures(drapes[i]->shape);
  return features;
}

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
  const Eigen::MatrixXd predicted = FeatureMatrix(samples), seen = FeatureMatrix(observed);
  const GrayImage mean = ComputeMean(samples);
  for (size_t i = 0; i < observed.size(); ++i) {
    sum_.mean_image_mse += MeanSquaredError(mean, observed[i]->image);
    for (int k = 0; k < kNumFeatures; ++k) AddFeature(k, predicted.row(k), seen(k, i));
  }
  const auto weights = scales_.cwiseInverse().asDiagonal();
  sum_.feature_energy += EnergyScores(weights * predicted, weights * seen).sum();
  sum_.outline_energy += EnergyScores(OutlineMatrix(samples), OutlineMatrix(observed)).sum();
  sum_.observed += static_cast<int>(observed.size());
}

DistributionScore DistributionScorer::Score() const {
  CHECK_GT(sum_.observed, 0);
  DistributionScore score = sum_;
  const double count = sum_.observed;
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
