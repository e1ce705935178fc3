// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/generative/weighted_drapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr int kNearest = 200;            // drapes from whose mean a fit starts
constexpr double kPenalty = 20.0;        // of too few effective drapes
constexpr double kNegligible = 1e-7;     // share of the largest weight
constexpr double kFirstDeviation = 0.7;  // of the largest

// Columns whose Euclidean distances add up to those of drapes.
struct Columns {
  Eigen::MatrixXf features;  // shape [kNumFeatures, n]
  Eigen::MatrixXf outlines;  // shape [kPoolAngles, n]

  Columns(Eigen::Index count, double outline_weight)
      : features(kNumFeatures, count),
        outlines(kPoolAngles, count),
        per_metre_(outline_weight / (kMilli * std::sqrt(double(kPoolAngles)))) {}
  void Set(Eigen::Index i, const DrapeShape& shape) {
    features.col(i) = shape.features.cwiseQuotient(kFeatureScales).cast<float>();
    outlines.col(i) = (shape.radius * per_metre_).cast<float>();
  }

 private:
  static constexpr double kMilli = 1e-3;
  double per_metre_;
};

// Of all columns of a to all of b, shape [b, a].
Eigen::MatrixXf DistancesBetween(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b) {
  Eigen::MatrixXf squared = -2.0f * (b.transpose() * a);
  squared.rowwise() += a.colwise().squaredNorm();
  squared.colwise() += b.colwise().squaredNorm().transpose();
  return squared.cwiseMax(0.0f).cwiseSqrt();
}
Eigen::MatrixXf DistancesBetween(const Columns& a, const Columns& b) {
  return DistancesBetween(a.features, b.features) + DistancesBetween(a.outlines, b.outlines);
}

using Box = Eigen::AlignedBox<double, kSpecimenNumbers>;

// Around the drapes most like the observed ones. *start: their mean, and large deviations.
Box GuessStart(const DrapePool& pool, const std::vector<NearDrape>& nearest,
               SpecimenDistribution* start) {
  Box box;
  start->mean[0].setZero();
  for (const NearDrape& near : nearest) {
    start->mean[0] += pool.drapes[near.index].numbers / double(nearest.size());
    box.extend(pool.drapes[near.index].numbers);
  }
  start->mean[1] = start->mean[0];
  for (int k = 0; k < kSpecimenNumbers; ++k)
    start->deviation[k] = std::max(NumberRanges()[k].least_deviation,
                                   kFirstDeviation * NumberRanges()[k].most_deviation);
  return box;
}

Box BoxAround(const std::vector<SpecimenDistribution>& starts) {
  Box box;
  for (const SpecimenDistribution& start : starts)
    for (const SpecimenNumbers& mean : start.mean)
      for (const double side : {-kFitReach, kFitReach})
        box.extend(SpecimenNumbers(mean + side * start.deviation));
  return box;
}

// That the directions of bend are confused is what most minima come from, so a search begins with
// other ones too.
std::vector<SpecimenDistribution> WithOtherDirections(const SpecimenDistribution& start) {
  std::vector<SpecimenDistribution> starts = {start};
  for (const double anisotropy : {-1.0, 1.0}) {
    starts.push_back(start);
    for (SpecimenNumbers& mean : starts.back().mean) mean[kBendAnisotropy] = anisotropy;
  }
  return starts;
}

// Of a distribution on one face, the sum 1, shape [n].
Eigen::VectorXd WeightsOfDrapes(const WeightedDrapes& drapes,
                                const SpecimenDistribution& distribution, int face) {
  const Eigen::Index n = drapes.numbers.cols();
  const Eigen::ArrayXXd z = (drapes.numbers.colwise() - distribution.mean[face])
                                .cwiseQuotient(distribution.deviation.replicate(1, n));
  const Eigen::ArrayXd log_weight =
      -0.5 * z.square().colwise().sum().transpose() - drapes.log_proposal.array();
  Eigen::VectorXd w = (log_weight - log_weight.maxCoeff()).exp();
  w = (w.array() > kNegligible).select(w, 0.0);
  return w / w.sum();
}

}  // namespace

std::vector<NearDrape> ListNearestDrapes(const DrapePool& pool,
                                         const std::vector<TrainingDrape>& seen,
                                         double outline_weight, int count) {
  Columns captures(static_cast<Eigen::Index>(seen.size()), outline_weight);
  for (std::size_t j = 0; j < seen.size(); ++j)
    captures.Set(static_cast<Eigen::Index>(j), seen[j].shape);
  Columns drapes(static_cast<Eigen::Index>(pool.drapes.size()), outline_weight);
  for (std::size_t i = 0; i < pool.drapes.size(); ++i)
    drapes.Set(static_cast<Eigen::Index>(i), pool.drapes[i].shape);
  const Eigen::VectorXf away = DistancesBetween(captures, drapes).rowwise().mean();
  std::vector<NearDrape> nearest;
  for (std::size_t i = 0; i < pool.drapes.size(); ++i)
    nearest.push_back({static_cast<int>(i), away[static_cast<Eigen::Index>(i)]});
  std::stable_sort(nearest.begin(), nearest.end(),
                   [](const NearDrape& a, const NearDrape& b) { return a.away < b.away; });
  nearest.resize(std::min<std::size_t>(nearest.size(), count));
  return nearest;
}

WeightedDrapes TakeNearDrapes(const DrapePool& pool, const std::vector<TrainingDrape>& training,
                              const DistributionFitOptions& options,
                              std::vector<SpecimenDistribution>* starts) {
  Columns captures(static_cast<Eigen::Index>(training.size()), options.outline_weight);
  WeightedDrapes drapes;
  for (std::size_t j = 0; j < training.size(); ++j) {
    captures.Set(static_cast<Eigen::Index>(j), training[j].shape);
    drapes.face.push_back(SpecimenDistribution::FaceIndex(training[j].face));
  }
  Box box = BoxAround(*starts);
  if (starts->empty()) {
    SpecimenDistribution guess;
    box = GuessStart(pool, ListNearestDrapes(pool, training, options.outline_weight, kNearest),
                     &guess);
    *starts = WithOtherDirections(guess);
  }
  std::vector<int> near;
  for (std::size_t i = 0; i < pool.drapes.size(); ++i)
    if (box.contains(pool.drapes[i].numbers)) near.push_back(static_cast<int>(i));
  if (static_cast<double>(near.size()) < 2 * options.least_effective)
    throw InputError("pool", "found " + std::to_string(near.size()) +
                                 " drapes near the fabric, expected at least " +
                                 std::to_string(static_cast<int>(2 * options.least_effective)));
  const auto n = static_cast<Eigen::Index>(near.size());
  const Eigen::VectorXd log_proposal = pool.LogProposal();
  drapes.numbers.resize(kSpecimenNumbers, n);
  drapes.log_proposal.resize(n);
  Columns used(n, options.outline_weight);
  for (Eigen::Index i = 0; i < n; ++i) {
    drapes.numbers.col(i) = pool.drapes[near[i]].numbers;
    drapes.log_proposal[i] = log_proposal[near[i]];
    used.Set(i, pool.drapes[near[i]].shape);
  }
  drapes.between = DistancesBetween(used, used);
  drapes.to_captures = DistancesBetween(captures, used);
  drapes.least_effective = options.least_effective;
  return drapes;
}

FaceScore ScoreFace(const WeightedDrapes& drapes, const SpecimenDistribution& distribution,
                    int face, const Eigen::VectorXd& capture_weights) {
  const Eigen::Index n = drapes.numbers.cols();
  const Eigen::VectorXd w = WeightsOfDrapes(drapes, distribution, face);
  const Eigen::VectorXf single = w.cast<float>();

  Eigen::VectorXd target = Eigen::VectorXd::Zero(n);
  double total = 0.0;
  for (std::size_t j = 0; j < drapes.face.size(); ++j) {
    if (drapes.face[j] != face || capture_weights[j] == 0.0) continue;
    target += capture_weights[j] * drapes.to_captures.col(j).cast<double>();
    total += capture_weights[j];
  }
  FaceScore result;
  Eigen::VectorXd by_weight = Eigen::VectorXd::Zero(n);
  double spread = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (w[i] == 0.0) continue;
    const double sum = drapes.between.col(i).dot(single);
    spread += w[i] * sum;
    by_weight[i] = target[i] - total * sum;
  }
  result.score = w.dot(target) - 0.5 * total * spread;
  result.by_log_weight = w.cwiseProduct((by_weight.array() - w.dot(by_weight)).matrix());
  const double power = w.squaredNorm();
  result.effective = 1.0 / power;
  const double lack = std::log(drapes.least_effective * power);
  if (lack > 0.0) {
    result.penalty = kPenalty * lack * lack;
    const Eigen::ArrayXd by_log = 2.0 * (w.array().square() - w.array() * power) / power;
    result.by_log_weight += (2.0 * kPenalty * lack * by_log).matrix();
  }
  return result;
}

std::array<bool, 2> ListSeenFaces(const WeightedDrapes& drapes,
                                  const Eigen::VectorXd& capture_weights) {
  std::array<bool, 2> seen = {};
  for (std::size_t j = 0; j < drapes.face.size(); ++j)
    if (capture_weights[static_cast<Eigen::Index>(j)] > 0.0) seen[drapes.face[j]] = true;
  return seen;
}

Eigen::VectorXd ScoreCaptures(const WeightedDrapes& drapes,
                              const SpecimenDistribution& distribution, double* effective) {
  const auto captures = static_cast<Eigen::Index>(drapes.face.size());
  const std::array<bool, 2> seen = ListSeenFaces(drapes, Eigen::VectorXd::Ones(captures));
  Eigen::VectorXd scores(captures);
  double least = std::numeric_limits<double>::infinity();
  for (int face = 0; face < 2; ++face) {
    if (!seen[face]) continue;
    const Eigen::VectorXd w = WeightsOfDrapes(drapes, distribution, face);
    const Eigen::VectorXf single = w.cast<float>();
    double spread = 0.0;
    for (Eigen::Index i = 0; i < w.size(); ++i)
      if (w[i] > 0.0) spread += w[i] * drapes.between.col(i).dot(single);
    for (Eigen::Index j = 0; j < captures; ++j)
      if (drapes.face[j] == face)
        scores[j] = w.dot(drapes.to_captures.col(j).cast<double>()) - 0.5 * spread;
    least = std::min(least, 1.0 / w.squaredNorm());
  }
  if (effective != nullptr) *effective = least;
  return scores;
}

}  // namespace drape
