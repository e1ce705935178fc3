// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/generative/distribution_fit.h"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>
#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "physics/util/errors.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

constexpr int kFaces = 2;
constexpr int kNearest = 200;            // drapes from whose mean a fit starts
constexpr double kPenalty = 20.0;        // of too few effective drapes
constexpr float kNegligible = 1e-7f;     // share of the largest weight
constexpr double kMostOfRange = 0.98;    // where a fit may start, of the range of a number
constexpr double kFirstDeviation = 0.7;  // of the largest

// Numbers of a fit: the means, those that differ by face once for each, and the log deviations, all
// mapped from their ranges to the real line.
constexpr int kDiffering = 2;
constexpr int kMeans = kSpecimenNumbers + kDiffering;
constexpr int kUnknowns = kMeans + kSpecimenNumbers;
static_assert(kUnknowns == kDistributionNumbers);

double Logistic(double u) { return 1.0 / (1.0 + std::exp(-u)); }
double Logit(double share) {
  share = std::clamp(share, (1 - kMostOfRange) / 2, (1 + kMostOfRange) / 2);
  return std::log(share / (1.0 - share));
}

// Of the mean of a number on a face among the unknowns.
int MeanIndex(int number, int face) {
  return face == 1 && DiffersByFace(number) ? kSpecimenNumbers + number : number;
}
static_assert(kLogBendingLength == 0 && kBendAnisotropy == 1, "MeanIndex counts on it");

struct Bounds {
  double low, high;
  double At(double u) const { return low + (high - low) * Logistic(u); }
  double From(double value) const { return Logit((value - low) / (high - low)); }
  double Slope(double u) const {
    const double share = Logistic(u);
    return (high - low) * share * (1.0 - share);
  }
};
Bounds MeanBounds(int number) { return {NumberRanges()[number].low, NumberRanges()[number].high}; }
Bounds DeviationBounds(int number) {
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
      u[MeanIndex(k, face)] = MeanBounds(k).From(distribution.mean[face][k]);
    u[kMeans + k] = DeviationBounds(k).From(std::log(distribution.deviation[k]));
  }
  return u;
}

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
Eigen::MatrixXf Distances(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b) {
  Eigen::MatrixXf squared = -2.0f * (b.transpose() * a);
  squared.rowwise() += a.colwise().squaredNorm();
  squared.colwise() += b.colwise().squaredNorm().transpose();
  return squared.cwiseMax(0.0f).cwiseSqrt();
}
Eigen::MatrixXf Distances(const Columns& a, const Columns& b) {
  return Distances(a.features, b.features) + Distances(a.outlines, b.outlines);
}

// What all fits to one training set share.
struct Problem {
  Eigen::MatrixXd numbers;       // of the drapes, shape [kSpecimenNumbers, n]
  Eigen::VectorXd log_proposal;  // shape [n]
  Eigen::MatrixXf between;       // distances of the drapes, shape [n, n]
  Eigen::MatrixXf to_captures;   // shape [n, captures]
  std::vector<int> face;         // of each capture
  double least_effective = 0.0;
  int iterations = 0;
};

struct FaceScore {
  double score = 0.0;  // sum over the captures, each times its weight
  double effective = 0.0;
  Eigen::VectorXd by_log_weight;  // gradient, shape [n]; of the penalty too
  double penalty = 0.0;
};

// The energy score of the drapes weighted for one face, for captures of these weights.
FaceScore ScoreFace(const Problem& problem, const SpecimenDistribution& distribution, int face,
                    const Eigen::VectorXd& capture_weights) {
  const Eigen::Index n = problem.numbers.cols();
  const Eigen::ArrayXXd z = (problem.numbers.colwise() - distribution.mean[face])
                                .cwiseQuotient(distribution.deviation.replicate(1, n));
  const Eigen::ArrayXd log_weight =
      -0.5 * z.square().colwise().sum().transpose() - problem.log_proposal.array();
  Eigen::VectorXd w = (log_weight - log_weight.maxCoeff()).exp();
  std::vector<int> active;
  for (int i = 0; i < n; ++i)
    if (w[i] > kNegligible) active.push_back(i);
  w /= w.sum();

  Eigen::VectorXd target = Eigen::VectorXd::Zero(n);
  double total = 0.0;
  for (std::size_t j = 0; j < problem.face.size(); ++j) {
    if (problem.face[j] != face || capture_weights[j] == 0.0) continue;
    target += capture_weights[j] * problem.to_captures.col(j).cast<double>();
    total += capture_weights[j];
  }
  FaceScore result;
  Eigen::VectorXd by_weight = Eigen::VectorXd::Zero(n);
  double spread = 0.0;
  for (const int i : active) {
    double sum = 0.0;
    const float* row = problem.between.col(i).data();
    for (const int j : active) sum += row[j] * w[j];
    spread += w[i] * sum;
    by_weight[i] = target[i] - total * sum;
  }
  result.score = w.dot(target) - 0.5 * total * spread;
  result.by_log_weight = w.cwiseProduct((by_weight.array() - w.dot(by_weight)).matrix());
  const double power = w.squaredNorm();
  result.effective = 1.0 / power;
  const double lack = std::log(problem.least_effective * power);
  if (lack > 0.0) {
    result.penalty = kPenalty * lack * lack;
    const Eigen::ArrayXd by_log = 2.0 * (w.array().square() - w.array() * power) / power;
    result.by_log_weight += (2.0 * kPenalty * lack * by_log).matrix();
  }
  return result;
}

class TotalScore : public ceres::FirstOrderFunction {
 public:
  TotalScore(const Problem& problem, Eigen::VectorXd capture_weights)
      : problem_(problem), weights_(std::move(capture_weights)) {
    for (std::size_t j = 0; j < problem.face.size(); ++j)
      if (weights_[j] > 0.0) seen_[problem.face[j]] = true;
  }
  int NumParameters() const override { return kUnknowns; }

  bool Evaluate(const double* u, double* cost, double* gradient) const override {
    const SpecimenDistribution at = DistributionAt(u);
    *cost = 0.0;
    if (gradient != nullptr) std::fill(gradient, gradient + kUnknowns, 0.0);
    for (int face = 0; face < kFaces; ++face) {
      if (!seen_[face]) continue;
      const FaceScore score = ScoreFace(problem_, at, face, weights_);
      *cost += score.score + score.penalty;
      if (gradient == nullptr) continue;
      for (int k = 0; k < kSpecimenNumbers; ++k) {
        const Eigen::ArrayXd z =
            (problem_.numbers.row(k).transpose().array() - at.mean[face][k]) / at.deviation[k];
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
  const Problem& problem_;
  Eigen::VectorXd weights_;
  std::array<bool, kFaces> seen_ = {};
};

SpecimenDistribution Minimise(const Problem& problem, const Eigen::VectorXd& capture_weights,
                              const SpecimenDistribution& start) {
  Unknowns u = UnknownsAt(start);
  const ceres::GradientProblem score(new TotalScore(problem, capture_weights));
  ceres::GradientProblemSolver::Options options;
  options.max_num_iterations = problem.iterations;
  options.logging_type = ceres::SILENT;
  options.function_tolerance = 1e-5;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, score, u.data(), &summary);
  SpecimenDistribution found = DistributionAt(u.data());
  // A face without a capture is as the other.
  std::array<bool, kFaces> seen = {};
  for (std::size_t j = 0; j < problem.face.size(); ++j)
    if (capture_weights[j] > 0.0) seen[problem.face[j]] = true;
  for (int face = 0; face < kFaces; ++face)
    if (!seen[face]) found.mean[face] = found.mean[1 - face];
  return found;
}

// Mean score of the captures with a weight.
double MeanScore(const Problem& problem, const SpecimenDistribution& at,
                 const Eigen::VectorXd& capture_weights, double* effective = nullptr) {
  double sum = 0.0;
  for (int face = 0; face < kFaces; ++face) {
    bool seen = false;
    for (std::size_t j = 0; j < problem.face.size(); ++j)
      seen = seen || (problem.face[j] == face && capture_weights[j] > 0.0);
    if (!seen) continue;
    const FaceScore score = ScoreFace(problem, at, face, capture_weights);
    sum += score.score;
    if (effective != nullptr) *effective = std::min(*effective, score.effective);
  }
  return sum / capture_weights.sum();
}

// A box of numbers.
struct Box {
  SpecimenNumbers low = SpecimenNumbers::Constant(std::numeric_limits<double>::infinity());
  SpecimenNumbers high = -low;

  void Add(const SpecimenNumbers& numbers) {
    low = low.cwiseMin(numbers);
    high = high.cwiseMax(numbers);
  }
  bool Has(const SpecimenNumbers& numbers) const {
    return (numbers.array() >= low.array()).all() && (numbers.array() <= high.array()).all();
  }
};

// Around the drapes most like the observed ones. *start: their mean, and large deviations.
Box GuessStart(const DrapePool& pool, const Columns& captures, const Columns& drapes,
               SpecimenDistribution* start) {
  const Eigen::VectorXf away = Distances(captures, drapes).rowwise().sum();
  std::vector<int> nearest(pool.drapes.size());
  std::iota(nearest.begin(), nearest.end(), 0);
  std::stable_sort(nearest.begin(), nearest.end(), [&](int a, int b) { return away[a] < away[b]; });
  nearest.resize(std::min<std::size_t>(nearest.size(), kNearest));
  Box box;
  start->mean[0].setZero();
  for (const int i : nearest) {
    start->mean[0] += pool.drapes[i].numbers / double(nearest.size());
    box.Add(pool.drapes[i].numbers);
  }
  start->mean[1] = start->mean[0];
  for (int k = 0; k < kSpecimenNumbers; ++k)
    start->deviation[k] = std::max(NumberRanges()[k].least_deviation,
                                   kFirstDeviation * NumberRanges()[k].most_deviation);
  return box;
}

Box BoxAround(const SpecimenDistribution& start) {
  Box box;
  for (const SpecimenNumbers& mean : start.mean)
    for (const double side : {-kFitReach, kFitReach}) box.Add(mean + side * start.deviation);
  return box;
}

// *start: where to begin; found, where `guess` is set.
Problem MakeProblem(const DrapePool& pool, const std::vector<TrainingDrape>& training,
                    const DistributionFitOptions& options, bool guess,
                    SpecimenDistribution* start) {
  Columns captures(static_cast<Eigen::Index>(training.size()), options.outline_weight);
  Problem problem;
  for (std::size_t j = 0; j < training.size(); ++j) {
    captures.Set(static_cast<Eigen::Index>(j), training[j].shape);
    problem.face.push_back(SpecimenDistribution::FaceIndex(training[j].face));
  }
  Box box = BoxAround(*start);
  if (guess) {
    const auto count = static_cast<Eigen::Index>(pool.drapes.size());
    Columns all(count, options.outline_weight);
    for (Eigen::Index i = 0; i < count; ++i) all.Set(i, pool.drapes[i].shape);
    box = GuessStart(pool, captures, all, start);
  }
  std::vector<int> near;
  for (std::size_t i = 0; i < pool.drapes.size(); ++i)
    if (box.Has(pool.drapes[i].numbers)) near.push_back(static_cast<int>(i));
  if (static_cast<double>(near.size()) < 2 * options.least_effective)
    throw InputError("pool", "found " + std::to_string(near.size()) +
                                 " drapes near the fabric, expected at least " +
                                 std::to_string(static_cast<int>(2 * options.least_effective)));
  const auto n = static_cast<Eigen::Index>(near.size());
  const Eigen::VectorXd log_proposal = pool.LogProposal();
  problem.numbers.resize(kSpecimenNumbers, n);
  problem.log_proposal.resize(n);
  Columns used(n, options.outline_weight);
  for (Eigen::Index i = 0; i < n; ++i) {
    problem.numbers.col(i) = pool.drapes[near[i]].numbers;
    problem.log_proposal[i] = log_proposal[near[i]];
    used.Set(i, pool.drapes[near[i]].shape);
  }
  problem.between = Distances(used, used);
  problem.to_captures = Distances(captures, used);
  problem.least_effective = options.least_effective;
  problem.iterations = options.iterations;
  return problem;
}

// Of each capture, which sample it is of, from 0.
std::vector<int> SampleOfCaptures(const std::vector<TrainingDrape>& training, int* samples) {
  std::set<int> numbers;
  for (const TrainingDrape& seen : training) numbers.insert(seen.sample);
  *samples = static_cast<int>(numbers.size());
  std::vector<int> of;
  for (const TrainingDrape& seen : training)
    of.push_back(static_cast<int>(std::distance(numbers.begin(), numbers.find(seen.sample))));
  return of;
}

// Dirichlet(1, …, 1), the mean 1.
Eigen::VectorXd RandomSampleWeights(int samples, uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::VectorXd weights(samples);
  for (double& weight : weights) weight = -std::log(1.0 - SampleUniform(random));
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
                                const SpecimenDistribution* known_start) {
  CHECK(!training.empty());
  SpecimenDistribution start = known_start != nullptr ? *known_start : SpecimenDistribution();
  const Problem problem = MakeProblem(pool, training, options, known_start == nullptr, &start);
  int samples = 0;
  const std::vector<int> sample_of = SampleOfCaptures(training, &samples);
  const auto weights_by_sample = [&](const Eigen::VectorXd& of_samples) {
    Eigen::VectorXd weights(training.size());
    for (std::size_t j = 0; j < training.size(); ++j) weights[j] = of_samples[sample_of[j]];
    return weights;
  };
  DistributionFit fit;
  fit.drapes = static_cast<int>(problem.numbers.cols());
  fit.cross_validated = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd equal = Eigen::VectorXd::Ones(training.size());
  fit.best = Minimise(problem, equal, start);
  fit.effective = std::numeric_limits<double>::infinity();
  fit.score = MeanScore(problem, fit.best, equal, &fit.effective);

  const int resamples = samples >= 2 ? options.resamples : 0;
  const int left_out = samples >= 2 && options.cross_validate ? samples : 0;
  std::vector<SpecimenDistribution> resampled(resamples);
  std::vector<double> scores(left_out);
  RunInThreads(resamples + left_out, options.threads, control.cancel, [&](int task) {
    if (task < resamples) {
      const Eigen::VectorXd of_samples =
          RandomSampleWeights(samples, SeedOfStream(options.seed, static_cast<uint64_t>(task)));
      resampled[task] = Minimise(problem, weights_by_sample(of_samples), fit.best);
      return;
    }
    Eigen::VectorXd only = Eigen::VectorXd::Zero(samples);
    only[task - resamples] = 1.0;
    const Eigen::VectorXd here = weights_by_sample(only);
    scores[task - resamples] = MeanScore(problem, Minimise(problem, equal - here, start), here);
  });
  if (control.cancelled()) return fit;
  fit.resampled = std::move(resampled);
  if (left_out > 0)
    fit.cross_validated = std::accumulate(scores.begin(), scores.end(), 0.0) / left_out;
  return fit;
}

double ScoreDistribution(const DrapePool& pool, const SpecimenDistribution& distribution,
                         const std::vector<TrainingDrape>& drapes,
                         const DistributionFitOptions& options, double* effective) {
  SpecimenDistribution around = distribution;
  const Problem problem = MakeProblem(pool, drapes, options, false, &around);
  double least = std::numeric_limits<double>::infinity();
  const double score =
      MeanScore(problem, distribution, Eigen::VectorXd::Ones(drapes.size()), &least);
  if (effective != nullptr) *effective = least;
  return score;
}

}  // namespace drape
