// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/generative/specimen_posterior.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <random>

#include "losses/outline/outline.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr int kAmplitudes = 8;                        // of waves 1 … 8 of the outline
constexpr int kFirstDirected = 2, kLastDirected = 4;  // waves that show where warp is
constexpr int kRegressors = kNumFeatures + kAmplitudes + 2 * (kLastDirected - kFirstDirected + 1);
constexpr double kRidge = 0.1;        // beside the weights of drapes, of which the largest is 1
constexpr double kFromBounds = 1e-6;  // BoundedNumber::From
constexpr double kLeastShare = 1e-9;  // of the largest weight

BoundedNumber InRange(int number) {
  return {NumberRanges()[number].low, NumberRanges()[number].high};
}

using Regressors = Eigen::Matrix<double, kRegressors, 1>;

Regressors ComputeRegressors(const DrapeShape& shape) {
  Regressors all;
  all.head<kNumFeatures>() = shape.features.cwiseQuotient(kFeatureScales);
  int next = kNumFeatures;
  for (int wave = 1; wave <= kAmplitudes; ++wave) {
    const std::complex<double> mode = ComputeMode(shape.radius, wave);
    all[next++] = std::abs(mode);
    if (wave < kFirstDirected || wave > kLastDirected) continue;
    all[next++] = mode.real();
    all[next++] = mode.imag();
  }
  return all;
}

// Regressors of drapes as differences from those of the seen ones, in standard deviations of these
// drapes; shape [drapes, kRegressors].
Eigen::MatrixXd StandardisedRegressors(const DrapePool& pool, const std::vector<NearDrape>& nearest,
                                       const std::vector<TrainingDrape>& seen) {
  Regressors here = Regressors::Zero();
  for (const TrainingDrape& drape : seen)
    here += ComputeRegressors(drape.shape) / double(seen.size());
  Eigen::MatrixXd all(nearest.size(), kRegressors);
  for (Eigen::Index row = 0; row < all.rows(); ++row)
    all.row(row) = (ComputeRegressors(pool.drapes[nearest[row].index].shape) - here).transpose();
  const Eigen::RowVectorXd mean = all.colwise().mean();
  const Eigen::RowVectorXd deviation =
      ((all.rowwise() - mean).colwise().squaredNorm() / double(all.rows())).cwiseSqrt();
  return all * deviation.cwiseMax(std::numeric_limits<double>::min()).cwiseInverse().asDiagonal();
}

// Numbers on the real line, shape [drapes, kSpecimenNumbers], as they would be where the regressors
// are zero, by a linear regression with these weights of the drapes.
void MoveAlongRegression(const Eigen::MatrixXd& regressors, const Eigen::VectorXd& weights,
                         Eigen::MatrixXd* numbers) {
  const Eigen::RowVectorXd mean = weights.transpose() * regressors / weights.sum();
  const Eigen::MatrixXd centred = regressors.rowwise() - mean;
  const Eigen::MatrixXd weighted = weights.asDiagonal() * centred;
  Eigen::MatrixXd normal = centred.transpose() * weighted;
  normal.diagonal().array() += kRidge;
  *numbers -= regressors * normal.ldlt().solve(weighted.transpose() * *numbers);
}

// Indices in proportion to the weights, whose sum is 1: one in each part of equal probability.
std::vector<int> SampleIndices(const Eigen::VectorXd& weights, int count, std::mt19937_64& random) {
  std::vector<int> indices;
  double sum = weights[0];
  int i = 0;
  for (int k = 0; k < count; ++k) {
    const double at = (k + SampleUniform(random)) / count;
    while (sum < at && i + 1 < weights.size()) sum += weights[++i];
    indices.push_back(i);
  }
  std::shuffle(indices.begin(), indices.end(), random);
  return indices;
}

}  // namespace

SpecimenPosterior InferSpecimen(const DrapePool& pool, const std::vector<TrainingDrape>& seen,
                                double outline_weight, int samples, uint64_t seed) {
  CHECK(!seen.empty());
  if (pool.drapes.size() < 2 * kPosteriorDrapes)
    throw InputError("pool", "found " + std::to_string(pool.drapes.size()) +
                                 " drapes, expected at least " +
                                 std::to_string(2 * kPosteriorDrapes));
  const std::vector<NearDrape> nearest =
      ListNearestDrapes(pool, seen, outline_weight, kPosteriorDrapes);
  const Eigen::VectorXd log_proposal = pool.LogProposal();
  Eigen::VectorXd weights(kPosteriorDrapes);
  Eigen::MatrixXd numbers(kPosteriorDrapes, kSpecimenNumbers);
  for (int row = 0; row < kPosteriorDrapes; ++row) {
    const auto& [index, away] = nearest[row];
    const double share = away / std::max(nearest.back().away, std::numeric_limits<double>::min());
    weights[row] = std::max(1.0 - share * share, kLeastShare) *
                   std::exp(log_proposal[nearest.front().index] - log_proposal[index]);
    for (int k = 0; k < kSpecimenNumbers; ++k)
      numbers(row, k) = InRange(k).From(pool.drapes[index].numbers[k], kFromBounds);
  }
  SpecimenPosterior posterior;
  posterior.nearest = nearest.front().away;
  if (posterior.has_like())
    MoveAlongRegression(StandardisedRegressors(pool, nearest, seen), weights, &numbers);
  weights /= weights.sum();
  for (int k = 0; k < kSpecimenNumbers; ++k)
    for (double& number : numbers.col(k)) number = InRange(k).At(number);

  posterior.mean = numbers.transpose() * weights;
  posterior.effective = 1.0 / weights.squaredNorm();
  std::mt19937_64 random(seed);
  for (const int row : SampleIndices(weights, samples, random))
    posterior.samples.emplace_back(numbers.row(row).transpose());
  return posterior;
}

}  // namespace drape
