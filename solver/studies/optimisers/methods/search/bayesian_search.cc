// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/search/bayesian_search.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "solver/studies/optimisers/methods/search/acquisition.h"

namespace drape {
namespace {

// Signal 1 and lengths of half the box, as the code of [Nayebi 2019] begins.
Hyperparameters MakePriorMean(int dimension, double noise_variance) {
  Hyperparameters mean = Hyperparameters::Zero(dimension + 2);
  mean[dimension + 1] = 0.5 * std::log(noise_variance);
  return mean;
}

}  // namespace

BayesianSearch::BayesianSearch(Embedding embedding, double bound,
                               const BayesianSearchOptions& options, uint64_t seed)
    : embedding_(std::move(embedding)),
      bound_(bound),
      options_(options),
      random_(seed),
      prior_mean_(MakePriorMean(embedding_.dimension(), options.initial_variance)),
      process_(options.kernel, prior_mean_) {
  CHECK_GE(options.initial_points, 1);
  CHECK_GE(options.candidates, 1);
  design_ = Eigen::MatrixXd::Zero(embedding_.dimension(), options.initial_points);
  const int drawn = options.initial_points - 1;  // 0 comes first
  if (drawn > 0)
    design_.rightCols(drawn) = SampleLatinHypercube(embedding_.dimension(), drawn, random_);
}

Eigen::VectorXd BayesianSearch::Propose() {
  CHECK_EQ(points_.size(), values_.size()) << "a point without its cost";
  const auto count = static_cast<Eigen::Index>(points_.size());
  points_.push_back(count < design_.cols() ? Eigen::VectorXd(design_.col(count)) : Choose());
  return bound_ * embedding_.Map(embedding_.box * points_.back());
}

void BayesianSearch::Report(std::optional<double> cost) {
  CHECK_EQ(points_.size(), values_.size() + 1) << "a cost without its point";
  constexpr double kLeastCost = 1e-300;  // of which there is a logarithm
  values_.push_back(cost ? std::log(std::max(*cost, kLeastCost))
                         : std::numeric_limits<double>::quiet_NaN());
}

Eigen::VectorXd BayesianSearch::Choose() {
  const Eigen::MatrixXd candidates =
      SampleLatinHypercube(embedding_.dimension(), options_.candidates, random_);
  const Eigen::VectorXd values = StandardisedValues();
  if (MustFit()) Fit(values);
  while (process_.size() < values.size())
    if (!process_.Add(points_[process_.size()])) Fit(values);
  const GaussianProcess::Posterior posterior = process_.Predict(values, candidates);
  const double least = values.minCoeff();
  Eigen::VectorXd merits(candidates.cols());
  for (Eigen::Index i = 0; i < merits.size(); ++i) {
    const double mean = posterior.mean[i], deviation = std::sqrt(posterior.variance[i]);
    merits[i] = options_.acquisition == BayesianSearchOptions::Acquisition::kExpectedImprovement
                    ? ExpectedImprovement(mean, deviation, least)
                    : UpperConfidenceBound(mean, deviation, static_cast<int>(values.size()),
                                           embedding_.dimension());
  }
  Eigen::Index best = 0;
  merits.maxCoeff(&best);
  return candidates.col(best);
}

bool BayesianSearch::MustFit() const {
  constexpr int kOftenUpTo = 25, kOften = 5, kSeldom = 20;
  const int count = static_cast<int>(points_.size());
  return (count - options_.initial_points) % (count <= kOftenUpTo ? kOften : kSeldom) == 0;
}

void BayesianSearch::Fit(const Eigen::VectorXd& values) {
  constexpr int kIterations = 50;
  constexpr double kMoreNoise = std::numbers::ln10;
  const Eigen::MatrixXd points = Points();
  Hyperparameters fitted = FitHyperparameters(options_.kernel, points, values,
                                              process_.hyperparameters(), prior_mean_, kIterations);
  process_ = GaussianProcess(options_.kernel, fitted);
  while (!process_.SetPoints(points)) {  // ends: the noise grows
    fitted.tail<1>().array() += kMoreNoise;
    process_ = GaussianProcess(options_.kernel, fitted);
  }
}

Eigen::MatrixXd BayesianSearch::Points() const {
  Eigen::MatrixXd points(embedding_.dimension(), static_cast<Eigen::Index>(points_.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i) points.col(i) = points_[i];
  return points;
}

Eigen::VectorXd BayesianSearch::StandardisedValues() const {
  Eigen::VectorXd values =
      Eigen::Map<const Eigen::VectorXd>(values_.data(), static_cast<Eigen::Index>(values_.size()));
  double worst = -std::numeric_limits<double>::infinity();
  for (const double value : values) worst = std::max(worst, value);  // of NaN the other one
  for (double& value : values)
    if (std::isnan(value)) value = std::isfinite(worst) ? worst : 0.0;
  values.array() -= values.mean();
  const double deviation = std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
  if (deviation > 0.0) values /= deviation;
  return values;
}

}  // namespace drape
