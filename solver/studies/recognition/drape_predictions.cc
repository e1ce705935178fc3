// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/recognition/drape_predictions.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>

#include "cuda/make_backend.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"
#include "solver/prediction/bend_calibration.h"
#include "solver/studies/cells/study_settings.h"
#include "solver/studies/recognition/recognition_scores.h"

namespace drape {
namespace {

constexpr int kWithoutNone = 0;

std::string PredictionFolder(const RecognitionJob& job) { return job.fits.out + "/prediction"; }

std::string SettingsPath(const RecognitionJob& job) {
  return PredictionFolder(job) + "/settings.json";
}

std::string PredictionFile(const RecognitionJob& job, const PredictionCell& cell) {
  return PredictionFolder(job) + "/" + cell.name + ".json";
}

std::string FabricPrediction(int fabric) { return "fabric_" + std::to_string(fabric); }

std::string LeftOutPrediction(int fabric, int sample) {
  return Format("fabric_%d_without_%d", fabric, sample);
}

// The fits that a prediction is of.
std::string FitNames(const FittedSamples& samples) {
  std::string names;
  for (const FittedSample& sample : samples.fitted) names += sample.cell->name + "\n";
  return names;
}

// Specimens of the fabric as the model has it; directions that the data do not determine are at
// the mean of all fits.
MaterialSource MakeSpecimens(const FittedSamples& samples, const PredictionCell& cell) {
  const SampleModel model = ModelOfPosteriors(samples, cell.without);
  const NormalDistribution& fabric = model.fabric(cell.fabric);
  const Eigen::MatrixXd axes = samples.leading.axes;
  const Eigen::MatrixXd root = (fabric.covariance + model.within()).llt().matrixL();
  const Eigen::VectorXd rest = samples.centre - axes * (axes.transpose() * samples.centre);
  double density = 0.0;
  for (const FittedSample& sample : samples.fitted)
    if (sample.fabric == cell.fabric) density = sample.belief.density;
  return [=, mean = fabric.mean, frame = samples.frame](int specimen) {
    std::mt19937_64 random(SeedOfStream(static_cast<uint64_t>(cell.fabric), specimen));
    Eigen::VectorXd noise(mean.size());
    for (double& value : noise) value = SampleNormal(random);
    const Eigen::VectorXd z = rest + axes * (mean + root * noise);
    return frame.Table(frame.prior_root * z, density);
  };
}

nlohmann::json FeatureRows(const std::vector<PredictedDrape>& drapes, ClothFace face) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ObservedDrape* drape : ObservedDrapes(drapes, face)) {
    const Eigen::VectorXd features = ScaledFeatures(*drape);
    rows.push_back(std::vector<double>(features.begin(), features.end()));
  }
  return rows;
}

std::vector<ObservedCapture> TrainingImages(const RecognitionJob& job, const FittedSamples& samples,
                                            const PredictionCell& cell) {
  std::vector<ObservedCapture> training;
  const int left_out = cell.without >= 0 ? samples.fitted[cell.without].sample : kWithoutNone;
  for (const ObservedCapture& image : job.images)
    if (image.capture.fabric == samples.fabrics[cell.fabric] && image.capture.sample != left_out)
      training.push_back(image);
  return training;
}

void RunPredictionCell(const RecognitionJob& job, const FittedSamples& samples,
                       const PredictionCell& cell, const std::atomic<bool>* cancel) {
  const FitSpec& fit = job.fits.fit;
  const auto model = std::make_shared<const ClothModel>(ParseMeshSpec(fit.mesh),
                                                        CusickScene(fit.contact), MakeLaw(fit.law));
  const auto backend = MakeBackend(fit.backend, model, 1);
  PredictionOptions options = job.prediction;
  options.faces = {ClothFace::kUp, ClothFace::kDown};
  options.specimens = std::max(2, job.draws / options.drapes_of_specimen());
  options.settle.steps.cancel = options.settle.equilibrium.cancel = cancel;
  options.batch = SettleBatchSize(*backend, 1);
  const MaterialSource materials = MakeSpecimens(samples, cell);
  if (job.calibrate)
    options.bend =
        CalibrateBend(*backend, materials, options, TrainingImages(job, samples, cell), {}).factors;
  const std::vector<PredictedDrape> drapes = SampleDrapes(*backend, materials, options);
  if (cancel != nullptr && cancel->load()) return;
  WriteStoredJson(PredictionFile(job, cell), kRecognitionPredictionFormat,
                  {{"fits", FitNames(samples)},
                   {"up", FeatureRows(drapes, ClothFace::kUp)},
                   {"down", FeatureRows(drapes, ClothFace::kDown)}},
                  1);
}

constexpr double kMostFeature = 1e6;  // so that their covariance is finite

Eigen::MatrixXd ReadFeatures(const JsonInput& input) {
  const int count = input.ExpectArray().Size();
  if (count <= kNumFeatures) input.Fail("the features of more drapes at rest");
  Eigen::MatrixXd features(kNumFeatures, count);
  for (int i = 0; i < count; ++i) {
    features.col(i) = input.At(i).Vector(kNumFeatures);
    if (features.col(i).cwiseAbs().maxCoeff() > kMostFeature)
      input.At(i).Fail(Format("features of at most %g", kMostFeature));
  }
  return features;
}

}  // namespace

std::vector<PredictionCell> ListPredictions(const FittedSamples& samples) {
  std::vector<PredictionCell> cells;
  for (int f = 0; f < int(samples.fabrics.size()); ++f)
    cells.push_back({f, -1, FabricPrediction(samples.fabrics[f])});
  for (int i = 0; i < int(samples.fitted.size()); ++i) {
    const FittedSample& sample = samples.fitted[i];
    cells.push_back(
        {sample.fabric, i, LeftOutPrediction(samples.fabrics[sample.fabric], sample.sample)});
  }
  return cells;
}

std::vector<std::string> ListPredictionNames(const std::vector<FitCell>& cells) {
  std::map<int, std::vector<int>> samples;  // by fabric
  for (const FitCell& cell : cells)
    samples[cell.captures[0].fabric].push_back(cell.captures[0].sample);
  std::erase_if(samples, [](const auto& each) { return each.second.size() < 2; });
  std::vector<std::string> names;
  for (const auto& [fabric, of_fabric] : samples) names.push_back(FabricPrediction(fabric));
  for (const auto& [fabric, of_fabric] : samples)
    for (const int sample : of_fabric) names.push_back(LeftOutPrediction(fabric, sample));
  return names;
}

bool HasPrediction(const RecognitionJob& job, const FittedSamples& samples,
                   const PredictionCell& cell) {
  const std::string path = PredictionFile(job, cell);
  if (!std::filesystem::exists(path)) return false;
  try {
    const nlohmann::json file = ReadStoredJson(path, kRecognitionPredictionFormat);
    return JsonInput(file, path).At("fits").String() == FitNames(samples);
  } catch (const InputError&) {
    return false;  // damaged, or of an earlier version
  }
}

void CheckPredictionSettings(const RecognitionJob& job) {
  CheckStudySettings(SettingsPath(job), job.prediction_settings, "predictions");
}

bool RunPredictions(const RecognitionJob& job, const FittedSamples& samples,
                    const std::vector<PredictionCell>& cells, const RunControl& control) {
  std::filesystem::create_directories(PredictionFolder(job));
  if (!job.share) RemoveTemporaries(PredictionFolder(job));  // those of other shares may be in use
  CheckPredictionSettings(job);
  AddStudySettings(SettingsPath(job), job.prediction_settings);
  std::vector<PredictionCell> todo;
  for (const PredictionCell& cell : cells)
    if (!HasPrediction(job, samples, cell)) todo.push_back(cell);
  std::mutex mutex;
  int done = 0;
  RunInThreads(static_cast<int>(todo.size()), job.fits.threads, control.cancel, [&](int i) {
    RunPredictionCell(job, samples, todo[i], control.cancel);
    const std::scoped_lock lock(mutex);
    ++done;
    control.Report(done / double(todo.size()),
                   Format("prediction %d of %d", done, static_cast<int>(todo.size())));
  });
  return !control.cancelled();
}

PredictedFeatures ReadPrediction(const RecognitionJob& job, const PredictionCell& cell) {
  const std::string path = PredictionFile(job, cell);
  const nlohmann::json file = ReadStoredJson(path, kRecognitionPredictionFormat);
  const JsonInput input(file, path);
  PredictedFeatures predicted;
  for (int face = 0; face < 2; ++face) {
    const Eigen::MatrixXd features = ReadFeatures(input.At(face == 0 ? "up" : "down"));
    const ShrunkMoments moments = EstimateShrunkMoments(features);
    predicted.face[face] = {moments.mean,
                            moments.covariance * (1.0 + 1.0 / double(features.cols()))};
  }
  return predicted;
}

}  // namespace drape
