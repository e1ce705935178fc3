// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/experiment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/metrics/comparison.h"
#include "losses/metrics/metrics.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/stored/stored_json.h"
#include "solver/fit/protocol/fit_checkpoint.h"
#include "solver/prediction/material_source.h"

namespace drape {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Version 1 knew no calibration, 2 calibrated stretch too, 3 had no checksum.
constexpr StoredFormat kPredictionFormat = {"drapefit-prediction", 4};
// The numbers that each prediction is scored by.
constexpr const char* kScores[] = {
    "mean_image_mse",    "dc_error",       "dc_crps",        "dc_coverage_50",
    "dc_width_50",       "dc_coverage_90", "dc_width_90",    "folds_error",
    "folds_crps",        "folds_width_50", "folds_width_90", "folds_coverage_50",
    "folds_coverage_90", "feature_energy", "hausdorff_m",    "outline_energy_m"};
constexpr double kFitShare = 0.8;  // of the time of an experiment

// The part of summary.json that a model must have got to; empty: the one table is all.
std::string SummaryPart(FitModel model) {
  if (model == FitModel::kHomogeneous) return "";
  return model == FitModel::kHeterogeneous ? "fields" : "posterior";
}

// The files that a fit leaves behind, by its summary.
std::vector<std::string> ListFitFiles(const nlohmann::json& summary) {
  if (!summary.contains("mean")) return {};  // nothing could be fitted
  if (summary.contains("posterior")) return {"material.json", "base.json", "posterior.json"};
  return {"material.json"};
}

std::optional<ExperimentStiffness> BeliefIn(const JsonInput& summary) {
  if (!summary.Has("posterior")) return {};
  const JsonInput posterior = summary.At("posterior");
  const JsonInput stretch = posterior.At("stretch_n_per_m"), bend = posterior.At("bend_n_m");
  return ExperimentStiffness{stretch.At(0).Number(), stretch.At(1).Number(), bend.At(0).Number(),
                             bend.At(1).Number()};
}

// summary.json, once the fit is done and it and its files can be read. Throws InputError otherwise.
nlohmann::json FinishedFit(const std::string& folder) {
  const std::string path = folder + "/summary.json";
  nlohmann::json summary = ReadJsonFile(path);
  const JsonInput input(summary, path);
  if (input.At("status").String() != "done") input.At("status").Fail("done");
  for (const std::string& file : ListFitFiles(summary)) ReadJsonFile(folder + "/" + file);
  if (summary.contains("mean")) {
    FitNumbers(summary, path);
    BeliefIn(input);
  }
  return summary;
}

// Why the fit of a model is none; empty: it is one.
std::string DescribeFailure(const nlohmann::json& summary, FitModel model) {
  if (!summary.contains("mean")) return "nothing could be fitted";
  const std::string part = SummaryPart(model);
  if (part.empty() || summary.contains(part)) return "";
  return "the " + part + " could not be fitted";
}

template <class Read>
auto OrNothing(const Read& read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// RunFitJob in the experiment's folder, from its checkpoint unless that is damaged.
bool RunFit(const ExperimentTask& task, const RunControl& control) {
  FitFiles files{.out = task.folder,
                 .checkpoint = task.checkpoint,
                 .keep_checkpoint = true,
                 .log = task.folder + "/fit.log",
                 .provenance = task.provenance};
  fs::remove(task.folder + "/prediction.json");  // of an earlier fit
  const RunControl fit{control.cancel, [&](double fraction, const std::string& note) {
                         control.Report(kFitShare * fraction, note);
                       }};
  files.resume =
      fs::exists(files.checkpoint) &&
      OrNothing([&] { return ReadStoredJson(files.checkpoint, kCheckpointFormat); }).has_value();
  return !RunFitJob(task.fit, task.data, files, fit).cancelled;
}

ordered_json CaptureScores(const std::vector<PredictedDrape>& drapes,
                           const std::vector<ObservedCapture>& held_out) {
  ordered_json scores = ordered_json::array();
  for (const ObservedCapture& seen : held_out) {
    const Capture& c = seen.capture;
    const auto score = ScorePrediction(drapes, {seen});
    scores.push_back({{"fabric", c.fabric},
                      {"sample", c.sample},
                      {"capture", c.capture},
                      {"feature_energy", score->feature_energy},
                      {"outline_energy_m", score->outline_energy}});
  }
  return scores;
}

// Draws of one fit, on one backend.
class Predictor {
 public:
  Predictor(const ExperimentTask& task, const RunControl& control)
      : task_(task),
        control_(control),
        model_(std::make_shared<const ClothModel>(
            ParseMeshSpec(task.fit.mesh), CusickScene(task.fit.contact), MakeLaw(task.fit.law))),
        backend_(MakeBackend(task.fit.backend, model_, task.fit.threads)),
        options_(task.prediction),
        materials_(ReadMaterialSource(task.folder, *model_, options_.seed)) {
    options_.settle.steps.cancel = options_.settle.equilibrium.cancel = control.cancel;
    options_.batch = SettleBatchSize(*backend_, task.fit.threads);
  }

  // Samples from here on are calibrated.
  BendCalibration Calibrate() {
    constexpr double kUsualTrials = 18;
    BendCalibration calibration =
        CalibrateBend(*backend_, materials_, options_, *task_.training, {}, [&](int trials) {
          Report(std::min(0.9, 0.3 + 0.6 * trials / kUsualTrials), "calibration");
        });
    options_.bend = calibration.factors;
    calibrated_ = true;
    return calibration;
  }

  std::vector<PredictedDrape> Draw() {
    Report(calibrated_ ? 0.9 : 0.0, "prediction");
    return SampleDrapes(*backend_, materials_, options_);
  }

  bool Cancelled() const { return control_.cancelled(); }

 private:
  void Report(double share, const std::string& stage) const {
    control_.Report(kFitShare + (1 - kFitShare) * share, stage);
  }

  const ExperimentTask& task_;
  const RunControl& control_;
  std::shared_ptr<const ClothModel> model_;
  std::unique_ptr<Backend> backend_;
  PredictionOptions options_;
  MaterialSource materials_;
  bool calibrated_ = false;
};

// What a comparison says of drapes, beside a failure where they cannot be scored.
void AddScores(const std::vector<PredictedDrape>& drapes,
               const std::vector<ObservedCapture>& held_out, ordered_json* json) {
  (*json)["draws"] = drapes.size();
  (*json)["at_rest"] = ObservedDrapes(drapes, ClothFace::kUnknown).size();
  const auto score = ScorePrediction(drapes, held_out);
  if (!score) {
    (*json)["failure"] = "a face that is held out has fewer than two draws at rest";
    return;
  }
  Numbers numbers = ComputeNumbers(*score);
  numbers["hausdorff_m"] = MeanPairHausdorff(drapes, held_out);
  (*json)["numbers"] = numbers;
  (*json)["score"] = ScoreJson(*score);
  (*json)["captures"] = CaptureScores(drapes, held_out);
}

// Those numbers of the fit as it is that a calibrated one is held against.
void AddAsFitted(const std::vector<PredictedDrape>& drapes,
                 const std::vector<ObservedCapture>& held_out, ordered_json* numbers) {
  const auto score = ScorePrediction(drapes, held_out);
  if (!score) return;
  const Numbers all = ComputeNumbers(*score);
  for (const char* key : {"mean_image_mse", "dc_error", "dc_coverage_90", "feature_energy"})
    (*numbers)[std::string(key) + "_as_fitted"] = all.at(key);
}

void WritePrediction(const ExperimentTask& task, const nlohmann::json& json) {
  WriteStoredJson(task.folder + "/prediction.json", kPredictionFormat, json, 1);
}

// The distribution of specimens, learned, sampled and scored.
bool LearnAndPredict(const ExperimentTask& task, const RunControl& control) {
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  const auto model = std::make_shared<const ClothModel>(
      ParseMeshSpec(task.fit.mesh), CusickScene(task.fit.contact), MakeLaw(task.fit.law));
  const auto backend = MakeBackend(task.fit.backend, model, task.fit.threads);
  const LearnedFabric learned = LearnFabric(*backend, *task.training, *task.learning, control);
  if (learned.cancelled) return false;
  const double learning_seconds = seconds();
  PredictionOptions options = task.prediction;
  options.settle.steps.cancel = options.settle.equilibrium.cancel = control.cancel;
  options.batch = SettleBatchSize(*backend, task.fit.threads);
  control.Report(kFitShare, "prediction");
  const std::vector<PredictedDrape> drapes = SampleSpecimens(*backend, learned.fit, options);
  if (control.cancelled()) return false;
  ordered_json json = {{"generative", true}};
  AddScores(drapes, *task.held_out, &json);
  if (json.contains("numbers")) {
    json["numbers"]["fit_seconds"] = learning_seconds;
    json["numbers"]["prediction_seconds"] = seconds() - learning_seconds;
    json["numbers"]["rollouts"] = learned.simulated;
    json["numbers"]["parameters"] = kDistributionNumbers;
  }
  json["energy_training"] = learned.fit.score;
  json["energy_cross_validated"] = learned.fit.cross_validated;
  json["effective_drapes"] = learned.fit.effective;
  WriteDistributionFit(task.folder + "/specimens.json", learned.fit);
  WritePrediction(task, json);
  return true;
}

bool Predict(const ExperimentTask& task, const RunControl& control) {
  const auto start = std::chrono::steady_clock::now();
  Predictor predictor(task, control);
  const std::vector<PredictedDrape> as_fitted = predictor.Draw();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  ordered_json json;
  if (task.calibrate) {
    const BendCalibration calibration = predictor.Calibrate();
    const std::chrono::duration<double> with = std::chrono::steady_clock::now() - start;
    AddScores(predictor.Draw(), *task.held_out, &json);
    if (json.contains("numbers")) {
      json["numbers"]["bend_factor_up"] = calibration.factors.up;
      json["numbers"]["bend_factor_down"] = calibration.factors.down;
      json["numbers"]["calibration_seconds"] = (with - seconds).count();
      AddAsFitted(as_fitted, *task.held_out, &json["numbers"]);
    }
  } else {
    AddScores(as_fitted, *task.held_out, &json);
  }
  if (predictor.Cancelled()) return false;
  if (json.contains("numbers")) json["numbers"]["prediction_seconds"] = seconds.count();
  WritePrediction(task, json);
  return true;
}

ExperimentResult ReadResult(const std::string& folder) {
  const std::string path = folder + "/prediction.json";
  const nlohmann::json prediction = ReadStoredJson(path, kPredictionFormat);
  const JsonInput input(prediction, path);
  const bool fitted = !input.Has("generative");
  const nlohmann::json summary = fitted ? FinishedFit(folder) : nlohmann::json::object();
  ExperimentResult result;
  if (input.Has("failure")) {
    result.failure = input.At("failure").String();
    return result;
  }
  if (fitted) result.numbers = FitNumbers(summary, folder + "/summary.json");
  const JsonInput numbers = input.At("numbers");
  for (const auto& [key, value] : numbers.ExpectObject().value().items())
    result.numbers[key] = numbers.At(key).NotNegative();
  for (const char* key : kScores) numbers.At(key);
  const JsonInput captures = input.At("captures");
  if (captures.ExpectArray().Size() == 0) captures.Fail("the scores of a capture or more");
  for (int i = 0; i < captures.Size(); ++i) {
    const JsonInput c = captures.At(i);
    result.captures.push_back({c.At("fabric").Integer(), c.At("sample").Integer(),
                               c.At("capture").Integer(), c.At("feature_energy").NotNegative()});
  }
  result.belief = BeliefIn(JsonInput(summary, folder + "/summary.json"));
  return result;
}

}  // namespace

std::optional<ExperimentResult> ReadExperiment(const std::string& folder) {
  return OrNothing([&] { return ReadResult(folder); });
}

bool RunExperiment(const ExperimentTask& task, const RunControl& control) {
  fs::create_directories(task.folder);
  if (task.learning) return LearnAndPredict(task, control);
  const bool fitted = OrNothing([&] { return FinishedFit(task.folder); }).has_value();
  if (!fitted && !RunFit(task, control)) return false;
  const std::string failure = DescribeFailure(FinishedFit(task.folder), task.fit.model);
  if (failure.empty()) return Predict(task, control);
  WritePrediction(task, {{"failure", failure}});
  return true;
}

double MeanPairHausdorff(const std::vector<PredictedDrape>& drapes,
                         const std::vector<ObservedCapture>& held_out) {
  double sum = 0.0;
  int pairs = 0;
  for (const ObservedCapture& seen : held_out)
    for (const ObservedDrape* draw : ObservedDrapes(drapes, seen.capture.face)) {
      sum += ComputeDistance(*draw, seen.drape).outline_hausdorff;
      ++pairs;
    }
  return sum / pairs;
}

}  // namespace drape
