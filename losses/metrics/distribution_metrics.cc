// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/distribution_metrics.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>

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

// The value at rank `rank`, from 1 to the number of values, with linear interpolation between
// values.
double AtRank(const std::vector<double>& sorted, double rank) {
  const double last = static_cast<double>(sorted.size()) - 1;
  const double position = std::clamp(rank - 1, 0.0, last);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - below) * (sorted[above] - sorted[below]);
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

double EnsembleCrps(std::vector<double> samples, double observed) {
  CHECK_GE(samples.size(), 2u);
  std::sort(samples.begin(), samples.end());
  const double m = static_cast<double>(samples.size());
  double distance = 0, spread = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    distance += std::abs(samples[i] - observed) / m;
    spread += (2.0 * i - m + 1) * samples[i];  // Σ_{i<j} (x_j − x_i) of sorted samples
  }
  return distance - spread / (m * (m - 1));
}

Eigen::VectorXd EnergyScores(const Eigen::MatrixXd& samples, const Eigen::MatrixXd& observed) {
  CHECK_GE(samples.cols(), 2);
  CHECK_EQ(samples.rows(), observed.rows());
  const double m = static_cast<double>(samples.cols());
  double spread = 0;
  for (Eigen::Index i = 1; i < samples.cols(); ++i)
    spread += (samples.leftCols(i).colwise() - samples.col(i)).colwise().norm().sum();
  Eigen::VectorXd scores(observed.cols());
  for (Eigen::Index i = 0; i < observed.cols(); ++i) {
    scores[i] =
        (samples.colwise() - observed.col(i)).colwise().norm().mean() - spread / (m * (m - 1));
  }
  return scores;
}

CentralInterval ComputeInterval(std::vector<double> samples, double probability) {
  CHECK_GE(samples.size(), 2u);
  CHECK(probability > 0 && probability < 1) << probability;
  std::sort(samples.begin(), samples.end());
  const double m = static_cast<double>(samples.size());
  const double nominal = std::min(probability, (m - 1) / (m + 1));
  const double rank = 0.5 * (1 - nominal) * (m + 1);
  return {AtRank(samples, rank), AtRank(samples, m + 1 - rank), nominal};
}

Spread SpreadOfValues(const std::vector<double>& values) {
  Spread spread;
  if (values.empty()) return spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  if (values.size() == 1) return spread;
  double squares = 0.0;
  for (const double value : values) squares += (value - spread.mean) * (value - spread.mean);
  spread.sd = std::sqrt(squares / static_cast<double>(values.size() - 1));
  return spread;
}

}  // namespace drape
