// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/generative/generative_prediction.h"

#include <glog/logging.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "losses/outline/outline.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/stored/stored_json.h"

namespace drape {
namespace {

constexpr int kAmplitudes = 8;                        // of waves 1 … 8 of the outline
constexpr int kFirstDirected = 2, kLastDirected = 4;  // waves that show where warp is
constexpr int kRegressors = kNumFeatures + kAmplitudes + 2 * (kLastDirected - kFirstDirected + 1);
constexpr double kRidge = 0.1;        // beside the weights of drapes, of which the largest is 1
constexpr double kFromBounds = 1e-6;  // BoundedNumber::From
constexpr double kLeastShare = 1e-9;  // of the largest weight
// The least deviation of a regressor, in its unit: beside its rounding errors in drapes that are
// all alike, a seen drape would be infinitely far from them.
constexpr double kLeastSpread = 1e-6;

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
  return all * deviation.cwiseMax(kLeastSpread).cwiseInverse().asDiagonal();
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

constexpr StoredFormat kFitFormat = {"drapefit-specimen-distribution", 1};
constexpr double kWidening = 1.3;         // of the deviations of a further round
constexpr int kRoughResamples = 8;        // from which it draws
constexpr uint64_t kRoundStream = 0x2bd;  // of the pool's seed

enum SpecimenStream : uint64_t { kNumbersOfSpecimen, kWavesOfSpecimen };

std::vector<SpecimenDistribution> Widened(std::vector<SpecimenDistribution> distributions) {
  for (SpecimenDistribution& each : distributions) each.deviation *= kWidening;
  return distributions;
}

std::vector<ClothFace> ListObservedFaces(const std::vector<ObservedCapture>& captures) {
  std::vector<ClothFace> faces;
  for (const ObservedCapture& seen : captures)
    if (std::find(faces.begin(), faces.end(), seen.capture.face) == faces.end())
      faces.push_back(seen.capture.face);
  return faces;
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

LearnedFabric LearnFabric(Backend& backend, const std::vector<ObservedCapture>& training,
                          const LearningOptions& options, const RunControl& control) {
  LearnedFabric learned;
  DrapePool pool = ReadOrSimulatePool(options.pool_file, backend, options.pool, control);
  learned.cancelled = pool.simulated < options.pool.drapes;
  if (learned.cancelled) return learned;
  const std::vector<TrainingDrape> drapes = ListTrainingDrapes(training);
  std::vector<SpecimenDistribution> found;
  for (int round = 1; round <= options.rounds; ++round) {
    DistributionFitOptions rough = options.fit;
    rough.resamples = kRoughResamples;
    rough.cross_validate = false;
    control.Report(0.0, "inference before round " + std::to_string(round));
    const DistributionFit fit = FitDistribution(pool, drapes, rough, control, found);
    PoolOptions near = options.pool;
    near.drapes = options.round_drapes;
    near.seed = SeedOfStream(options.pool.seed, kRoundStream + static_cast<uint64_t>(round));
    near.from.around = Widened(fit.resampled.empty() ? std::vector{fit.best} : fit.resampled);
    near.from.faces = ListObservedFaces(training);
    const DrapePool further = SimulatePool(backend, near, control);
    learned.cancelled = control.cancelled() || further.simulated < near.drapes;
    if (learned.cancelled) return learned;
    pool = Join(std::move(pool), further);
    found = Widened(fit.minima);
  }
  control.Report(0.0, "inference");
  learned.fit = FitDistribution(pool, drapes, options.fit, control, found);
  learned.cancelled = control.cancelled();
  learned.at_rest = static_cast<int>(pool.drapes.size());
  learned.simulated = pool.simulated;
  return learned;
}

std::vector<PredictedDrape> SampleSpecimens(Backend& backend, const DistributionFit& fit,
                                            const PredictionOptions& options,
                                            const std::function<void(int done)>& progress) {
  const ClothModel& model = backend.model();
  const auto task = [&](int drape) -> DrapeTask {
    const PredictedDrape which = NumberedDrape(options, drape);
    const uint64_t seed = SpecimenSeed(options, which.specimen);
    const SpecimenDistribution& of_specimen =
        fit.resampled.empty() ? fit.best : fit.resampled[which.specimen % fit.resampled.size()];
    const SpecimenNumbers numbers =
        SampleNumbers(of_specimen, which.face, SeedOfStream(seed, kNumbersOfSpecimen));
    return {SpecimenMaterial(numbers),
            StartOfDrape(model, options, which,
                         SpecimenStart(numbers, SeedOfStream(seed, kWavesOfSpecimen)))};
  };
  return SampleTasks(backend, task, options, progress);
}

void WriteDistributionFit(const std::string& path, const DistributionFit& fit) {
  nlohmann::json resampled = nlohmann::json::array();
  for (const SpecimenDistribution& each : fit.resampled)
    resampled.push_back(nlohmann::json(DistributionJson(each)));
  WriteStoredJson(path, kFitFormat,
                  {{"best", DistributionJson(fit.best)},
                   {"resampled", resampled},
                   {"score", fit.score},
                   {"cross_validated", fit.cross_validated},
                   {"effective_drapes", fit.effective},
                   {"drapes", fit.drapes}});
}

DistributionFit ReadDistributionFit(const std::string& path) {
  const nlohmann::json json = ParseStoredJson(ReadWholeFile(path), path, kFitFormat);
  const JsonInput input(json, path);
  DistributionFit fit;
  fit.best = DistributionFromJson(input.At("best").value(), path + ": best");
  const JsonInput resampled = input.At("resampled");
  for (int i = 0; i < resampled.ExpectArray().Size(); ++i)
    fit.resampled.push_back(
        DistributionFromJson(resampled.At(i).value(), path + ": resampled " + std::to_string(i)));
  fit.score = input.At("score").Number();
  if (!input.At("cross_validated").value().is_null())
    fit.cross_validated = input.At("cross_validated").Number();
  fit.drapes = input.At("drapes").IntegerWithin(1, std::numeric_limits<int>::max());
  fit.effective = input.At("effective_drapes").NumberWithin(0, fit.drapes);
  return fit;
}

}  // namespace drape
