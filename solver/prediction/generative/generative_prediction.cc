// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/generative/generative_prediction.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/stored/stored_json.h"

namespace drape {
namespace {

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
                   {"drapes", fit.drapes}},
                  1);
}

DistributionFit ReadDistributionFit(const std::string& path) {
  const nlohmann::json json = ReadStoredJson(path, kFitFormat);
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
  fit.effective = input.At("effective_drapes").Number();
  fit.drapes = input.At("drapes").Integer();
  return fit;
}

}  // namespace drape
