// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/generative/distribution_fit.h"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <glog/logging.h>

#include <Eigen/Geometry>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "physics/util/errors.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr int kFaces = 2;
constexpr double kFromEnds = 0.01;  // where a fit may start (BoundedNumber::From)
// Minima are one where all means are within this many deviations.
constexpr double kSameMinimum = 0.5;

// Numbers of a fit: the means, those that differ by face once for each, and the log deviations, all
// mapped from their ranges to the real line.
constexpr int kDiffering = 2;
constexpr int kMeans = kSpecimenNumbers + kDiffering;
constexpr int kUnknowns = kMeans + kSpecimenNumbers;
static_assert(kUnknowns == kDistributionNumbers);

// The index of the mean of a number on a face among the unknowns.
int MeanIndex(int number, int face) {
  return face == 1 && DiffersByFace(number) ? kSpecimenNumbers + number : number;
}
static_assert(kLogBendingLength == 0 && kBendAnisotropy == 1, "MeanIndex counts on it");

BoundedNumber MeanBounds(int number) {
  return {NumberRanges()[number].low, NumberRanges()[number].high};
}
BoundedNumber DeviationBounds(int number) {
  const NumberRange& range = NumberRanges()[number];
  return {std::log(range.least_deviation), std::log(range.most_deviation)};
}

using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;

SpecimenDistribution DistributionAt(const double* u) {
  SpecimenDistribution distribution;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    for (int face = 0; face < kFaces; ++face)
      distribution.mean[face][k] = MeanBounds(k).At(u[MeanIndex(k, face)]);
    distribution.deviation[k] = std::exp(DeviationBounds(k).At(u[kMeans + k]));
  }
  return distribution;
}

Unknowns UnknownsAt(const SpecimenDistribution& distribution) {
  Unknowns u;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    for (int face = 0; face < kFaces; ++face)
      u[MeanIndex(k, face)] = MeanBounds(k).From(distribution.mean[face][k], kFromEnds);
    u[kMeans + k] = DeviationBounds(k).From(std::log(distribution.deviation[k]), kFromEnds);
  }
  return u;
}

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

// The distances of all columns of a to all columns of b, shape [b, a].
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

// Most minima come from confused directions of bend, so a search begins with other directions too.
std::vector<SpecimenDistribution> WithOtherDirections(const SpecimenDistribution& start) {
  std::vector<SpecimenDistribution> starts = {start};
  for (const double anisotropy : {-1.0, 1.0}) {
    starts.push_back(start);
    for (SpecimenNumbers& mean : starts.back().mean) mean[kBendAnisotropy] = anisotropy;
  }
  return starts;
}

// Drapes of a pool near a fabric, which with weights are a prediction of any distribution of its
// specimens, and the distances that the energy score of it takes [METHODS, P72].
struct WeightedDrapes {
  Eigen::MatrixXd numbers;       // of the drapes, shape [kSpecimenNumbers, n]
  Eigen::VectorXd log_proposal;  // shape [n]
  Eigen::MatrixXf between;       // distances of the drapes, shape [n, n]
  Eigen::MatrixXf to_captures;   // shape [n, captures]
  std::vector<int> face;         // of each capture: SpecimenDistribution::FaceIndex
  double least_effective = 0.0;  // DistributionFitOptions
};

// The weights of the drapes in a distribution on one face, with the sum 1, shape [n].
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

// Whether a capture with a weight shows each face. capture_weights: shape [captures].
std::array<bool, kFaces> ListSeenFaces(const WeightedDrapes& drapes,
                                       const Eigen::VectorXd& capture_weights) {
  std::array<bool, kFaces> seen = {};
  for (std::size_t j = 0; j < drapes.face.size(); ++j)
    if (capture_weights[static_cast<Eigen::Index>(j)] > 0.0) seen[drapes.face[j]] = true;
  return seen;
}

struct FaceScore {
  double score = 0.0;             // sum over the captures, each times its weight
  double penalty = 0.0;           // of too few effective drapes
  Eigen::VectorXd by_log_weight;  // gradient of score and penalty, shape [n]
};

// The energy score of the drapes weighted for one face, for captures of these weights.
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
  const double lack = std::log(drapes.least_effective * power);
  if (lack > 0.0) {
    result.penalty = kPenalty * lack * lack;
    const Eigen::ArrayXd by_log = 2.0 * (w.array().square() - w.array() * power) / power;
    result.by_log_weight += (2.0 * kPenalty * lack * by_log).matrix();
  }
  return result;
}

// The energy score of each capture, shape [captures]. *effective, if wanted: the number of drapes
// of the worse face of the captures.
Eigen::VectorXd ScoreCaptures(const WeightedDrapes& drapes,
                              const SpecimenDistribution& distribution,
                              double* effective = nullptr) {
  const auto captures = static_cast<Eigen::Index>(drapes.face.size());
  const std::array<bool, kFaces> seen = ListSeenFaces(drapes, Eigen::VectorXd::Ones(captures));
  Eigen::VectorXd scores(captures);
  double least = std::numeric_limits<double>::infinity();
  for (int face = 0; face < kFaces; ++face) {
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

// starts: where a search begins; then the drapes are those within kFitReach deviations of them.
// Empty: filled in with what the drapes most like the observed ones suggest, and the drapes are
// those between the numbers of these. Throws InputError (prefix "pool") where there are too few.
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

// The score of the drapes under a distribution, as a function of its unknowns.
class TotalScore : public ceres::FirstOrderFunction {
 public:
  TotalScore(const WeightedDrapes& drapes, Eigen::VectorXd capture_weights)
      : drapes_(drapes),
        weights_(std::move(capture_weights)),
        seen_(ListSeenFaces(drapes, weights_)) {}
  int NumParameters() const override { return kUnknowns; }

  bool Evaluate(const double* u, double* cost, double* gradient) const override {
    const SpecimenDistribution at = DistributionAt(u);
    *cost = 0.0;
    if (gradient != nullptr) std::fill(gradient, gradient + kUnknowns, 0.0);
    for (int face = 0; face < kFaces; ++face) {
      if (!seen_[face]) continue;
      const FaceScore score = ScoreFace(drapes_, at, face, weights_);
      *cost += score.score + score.penalty;
      if (gradient == nullptr) continue;
      for (int k = 0; k < kSpecimenNumbers; ++k) {
        const Eigen::ArrayXd z =
            (drapes_.numbers.row(k).transpose().array() - at.mean[face][k]) / at.deviation[k];
        const int mean = MeanIndex(k, face);
        gradient[mean] +=
            score.by_log_weight.dot(z.matrix()) / at.deviation[k] * MeanBounds(k).Slope(u[mean]);
        gradient[kMeans + k] +=
            score.by_log_weight.dot(z.square().matrix()) * DeviationBounds(k).Slope(u[kMeans + k]);
      }
    }
    return std::isfinite(*cost);
  }

 private:
  const WeightedDrapes& drapes_;
  Eigen::VectorXd weights_;
  std::array<bool, kFaces> seen_;
};

struct Minimum {
  SpecimenDistribution at;
  double cost = std::numeric_limits<double>::infinity();  // until a search has ended well
};

// Finds minima of the score of these drapes, for captures of given weights.
struct Search {
  const WeightedDrapes& drapes;
  int iterations;

  Minimum From(const SpecimenDistribution& start, const Eigen::VectorXd& capture_weights) const {
    Unknowns u = UnknownsAt(start);
    const ceres::GradientProblem score(new TotalScore(drapes, capture_weights));
    ceres::GradientProblemSolver::Options options;
    options.max_num_iterations = iterations;
    options.logging_type = ceres::SILENT;
    options.function_tolerance = 1e-5;
    ceres::GradientProblemSolver::Summary summary;
    ceres::Solve(options, score, u.data(), &summary);
    Minimum found{DistributionAt(u.data())};
    if (summary.IsSolutionUsable()) found.cost = summary.final_cost;
    // A face without a capture is as the other.
    const std::array<bool, kFaces> seen = ListSeenFaces(drapes, capture_weights);
    for (int face = 0; face < kFaces; ++face)
      if (!seen[face]) found.at.mean[face] = found.at.mean[1 - face];
    return found;
  }
  SpecimenDistribution FromAll(const std::vector<SpecimenDistribution>& starts,
                               const Eigen::VectorXd& capture_weights) const {
    Minimum best = From(starts.front(), capture_weights);
    for (std::size_t i = 1; i < starts.size(); ++i) {
      const Minimum found = From(starts[i], capture_weights);
      if (found.cost < best.cost) best = found;
    }
    return best.at;
  }
};

bool AreSame(const SpecimenDistribution& a, const SpecimenDistribution& b) {
  for (int face = 0; face < kFaces; ++face)
    for (int k = 0; k < kSpecimenNumbers; ++k)
      if (std::abs(a.mean[face][k] - b.mean[face][k]) > kSameMinimum * a.deviation[k]) return false;
  return true;
}

// The different ones, the best first.
std::vector<SpecimenDistribution> ListMinima(std::vector<Minimum> found) {
  std::stable_sort(found.begin(), found.end(),
                   [](const Minimum& a, const Minimum& b) { return a.cost < b.cost; });
  std::vector<SpecimenDistribution> minima;
  for (const Minimum& each : found)
    if (std::none_of(minima.begin(), minima.end(),
                     [&](const SpecimenDistribution& other) { return AreSame(other, each.at); }))
      minima.push_back(each.at);
  return minima;
}

// The sample of each capture, from 0.
std::vector<int> SampleOfCaptures(const std::vector<TrainingDrape>& training, int* samples) {
  std::set<int> numbers;
  for (const TrainingDrape& seen : training) numbers.insert(seen.sample);
  *samples = static_cast<int>(numbers.size());
  std::vector<int> of;
  for (const TrainingDrape& seen : training)
    of.push_back(static_cast<int>(std::distance(numbers.begin(), numbers.find(seen.sample))));
  return of;
}

// Dirichlet(½, …, ½), the mean 1. With the usual 1 in place of ½, intervals are too narrow; this is
// calibrated on simulated fabrics (tests/bench/CALIBRATION.md) [Syring 2019].
Eigen::VectorXd RandomSampleWeights(int samples, uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::VectorXd weights(samples);
  for (double& weight : weights) {
    const double z = SampleNormal(random);
    weight = z * z;
  }
  return weights * (samples / weights.sum());
}

}  // namespace

std::vector<TrainingDrape> ListTrainingDrapes(const std::vector<ObservedCapture>& captures) {
  std::vector<TrainingDrape> drapes;
  for (const ObservedCapture& seen : captures)
    drapes.push_back({seen.capture.sample, seen.capture.face, ComputeDrapeShape(seen.drape)});
  return drapes;
}

DistributionFit FitDistribution(const DrapePool& pool, const std::vector<TrainingDrape>& training,
                                const DistributionFitOptions& options, const RunControl& control,
                                std::vector<SpecimenDistribution> starts) {
  CHECK(!training.empty());
  const WeightedDrapes drapes = TakeNearDrapes(pool, training, options, &starts);
  const Search search{drapes, options.iterations};
  int samples = 0;
  const std::vector<int> sample_of = SampleOfCaptures(training, &samples);
  const auto weights_by_sample = [&](const Eigen::VectorXd& of_samples) {
    Eigen::VectorXd weights(training.size());
    for (std::size_t j = 0; j < training.size(); ++j) weights[j] = of_samples[sample_of[j]];
    return weights;
  };
  DistributionFit fit;
  fit.drapes = static_cast<int>(drapes.numbers.cols());
  fit.cross_validated = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(training.size());
  std::vector<Minimum> found(starts.size());
  RunInThreads(static_cast<int>(starts.size()), options.threads, nullptr,
               [&](int i) { found[i] = search.From(starts[i], equal); });
  fit.minima = ListMinima(std::move(found));
  fit.best = fit.minima.front();
  fit.score = ScoreCaptures(drapes, fit.best, &fit.effective).mean();

  const int resamples = samples >= 2 ? options.resamples : 0;
  const int left_out = samples >= 2 && options.cross_validate ? samples : 0;
  std::vector<SpecimenDistribution> resampled(resamples);
  std::vector<double> scores(left_out);
  RunInThreads(resamples + left_out, options.threads, control.cancel, [&](int task) {
    if (task < resamples) {
      const Eigen::VectorXd of_samples =
          RandomSampleWeights(samples, SeedOfStream(options.seed, static_cast<uint64_t>(task)));
      resampled[task] = search.FromAll(fit.minima, weights_by_sample(of_samples));
      return;
    }
    Eigen::VectorXd only = Eigen::VectorXd::Zero(samples);
    only[task - resamples] = 1.0;
    const Eigen::VectorXd here = weights_by_sample(only);
    const SpecimenDistribution learned = search.FromAll(starts, equal - here);
    scores[task - resamples] = here.dot(ScoreCaptures(drapes, learned)) / here.sum();
  });
  if (control.cancelled()) return fit;
  fit.resampled = std::move(resampled);
  if (left_out > 0)
    fit.cross_validated = std::accumulate(scores.begin(), scores.end(), 0.0) / left_out;
  return fit;
}

Eigen::VectorXd ScoreDrapes(const DrapePool& pool, const SpecimenDistribution& distribution,
                            const std::vector<TrainingDrape>& drapes,
                            const DistributionFitOptions& options, double* effective) {
  std::vector<SpecimenDistribution> around = {distribution};
  const WeightedDrapes near = TakeNearDrapes(pool, drapes, options, &around);
  return ScoreCaptures(near, distribution, effective);
}

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

}  // namespace drape
