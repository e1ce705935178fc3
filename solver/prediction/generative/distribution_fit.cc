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

#include "physics/util/math/random.h"
#include "solver/prediction/generative/weighted_drapes.h"

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

// Of the mean of a number on a face among the unknowns.
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

}  // namespace drape
