// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/experiment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>

#include "cuda/make_backend.h"
#include "losses/metrics/comparison.h"
#include "losses/metrics/metrics.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"
#include "solver/posterior/posterior_io.h"
#include "solver/prediction/bend_calibration.h"
#include "solver/prediction/material_source.h"

namespace drape {
namespace {

using nlohmann::json;

constexpr double kFitShare = 0.8;  // of the time of a run

class Stopwatch {
 public:
  double Seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void AddFeature(const std::string& name, const FeatureScore& feature, json* numbers) {
  (*numbers)[name + "_error"] = std::abs(feature.predicted_mean - feature.observed_mean);
  (*numbers)[name + "_crps"] = feature.crps;
  (*numbers)[name + "_coverage_50"] = feature.half.coverage;
  (*numbers)[name + "_width_50"] = feature.half.width;
  (*numbers)[name + "_coverage_90"] = feature.ninety.coverage;
  (*numbers)[name + "_width_90"] = feature.ninety.width;
}

// A number, or the sum of the numbers of a list or an object.
double ReadSum(const json& value) {
  if (value.is_number()) return value.get<double>();
  double sum = 0.0;
  for (const json& each : value) sum += each.get<double>();
  return sum;
}

json FitNumbers(const json& summary) {
  const json& mean = summary.at("mean");
  json numbers = {{"train_mse", mean.at("mse")},
                  {"train_profile_rms_px", mean.at("profile_rms_px")},
                  {"train_iou", mean.at("iou")},
                  {"train_hausdorff_m", mean.at("outline_hausdorff_m")},
                  {"parameters", summary.at("parameters").at("count")}};
  double seconds = ReadSum(summary.at("seconds")), rollouts = summary.at("rollouts");
  for (const char* part : {"fields", "posterior"}) {
    if (!summary.contains(part)) continue;
    seconds += ReadSum(summary.at(part).at("seconds"));
    rollouts += summary.at(part).at("rollouts").get<double>();
  }
  numbers["fit_seconds"] = seconds;
  numbers["rollouts"] = rollouts;
  if (summary.contains("fields")) numbers["parameters"] = summary.at("fields").at("parameters");
  if (summary.contains("posterior")) {
    const json& posterior = summary.at("posterior");
    const bool pairs = posterior.at("kind") == ToString(PosteriorKind::kElements);
    numbers["parameters"] = posterior.at("log_factors").size() * (pairs ? 2 : 1);
    if (posterior.at("elbo").is_number()) numbers["elbo"] = posterior.at("elbo");
  }
  return numbers;
}

// The part of summary.json that a fit of the model must have reached; empty: one table is all.
std::string SummaryPart(FitModel model) {
  if (model == FitModel::kHomogeneous) return "";
  return model == FitModel::kHeterogeneous ? "fields" : "posterior";
}

// Why a model could not be fitted; empty: it was.
std::string DescribeFailure(const json& summary, FitModel model) {
  if (!summary.contains("mean")) return "nothing could be fitted";
  const std::string part = SummaryPart(model);
  if (part.empty() || summary.contains(part)) return "";
  return "the " + part + " could not be fitted";
}

// Mean distance of the outlines of draws and the captures of their face [m].
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

json CaptureScores(const std::vector<PredictedDrape>& drapes,
                   const std::vector<ObservedCapture>& held_out) {
  json scores = json::array();
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

void AddScores(const std::vector<PredictedDrape>& drapes,
               const std::vector<ObservedCapture>& held_out, json* result) {
  (*result)["draws"] = drapes.size();
  (*result)["at_rest"] = ObservedDrapes(drapes, ClothFace::kUnknown).size();
  const auto score = ScorePrediction(drapes, held_out);
  if (!score) {
    result->erase("numbers");
    (*result)["failure"] = "a face that is held out has fewer than two draws at rest";
    return;
  }
  (*result)["numbers"].update(ScoreNumbers(*score));
  (*result)["numbers"]["hausdorff_m"] = MeanPairHausdorff(drapes, held_out);
  (*result)["score"] = ScoreJson(*score);
  (*result)["captures"] = CaptureScores(drapes, held_out);
}

// Scores of the uncalibrated fit, for comparison.
void AddAsFitted(const std::vector<PredictedDrape>& drapes,
                 const std::vector<ObservedCapture>& held_out, json* numbers) {
  const auto score = ScorePrediction(drapes, held_out);
  if (!score) return;
  const json all = ScoreNumbers(*score);
  for (const char* key : {"mean_image_mse", "dc_error", "dc_coverage_90", "feature_energy"})
    (*numbers)[std::string(key) + "_as_fitted"] = all.at(key);
}

std::unique_ptr<Backend> MakeTaskBackend(const ExperimentTask& task) {
  const auto model = std::make_shared<const ClothModel>(
      ParseMeshSpec(task.fit.mesh), CusickScene(task.fit.contact), MakeLaw(task.fit.law));
  return MakeBackend(task.fit.backend, model, task.fit.threads);
}

PredictionOptions MakeOptions(const ExperimentTask& task, const Backend& backend,
                              const RunControl& control) {
  PredictionOptions options = task.prediction;
  options.settle.steps.cancel = options.settle.equilibrium.cancel = control.cancel;
  options.batch = SettleBatchSize(backend, task.fit.threads);
  return options;
}

std::optional<json> LearnAndPredict(const ExperimentTask& task, const RunControl& control) {
  const Stopwatch watch;
  const auto backend = MakeTaskBackend(task);
  const LearnedFabric learned = LearnFabric(*backend, *task.training, *task.learning, control);
  if (learned.cancelled) return {};
  const double learning_seconds = watch.Seconds();
  control.Report(kFitShare, "prediction");
  const std::vector<PredictedDrape> drapes =
      SampleSpecimens(*backend, learned.fit, MakeOptions(task, *backend, control));
  if (control.cancelled()) return {};
  json result = {{"numbers",
                  {{"fit_seconds", learning_seconds},
                   {"prediction_seconds", watch.Seconds() - learning_seconds},
                   {"rollouts", learned.simulated},
                   {"parameters", kDistributionNumbers}}},
                 {"energy_training", learned.fit.score},
                 {"energy_cross_validated", learned.fit.cross_validated},
                 {"effective_drapes", learned.fit.effective}};
  AddScores(drapes, *task.held_out, &result);
  WriteDistributionFit(task.folder + "/specimens.json", learned.fit);
  return result;
}

// Samples drapes of the fit in the folder of the task, and scores it; `result` has the numbers of
// the fit.
std::optional<json> Predict(const ExperimentTask& task, const RunControl& control, json result) {
  constexpr double kUsualTrials = 18;
  const auto report = [&](double share, const char* stage) {
    control.Report(kFitShare + (1 - kFitShare) * share, stage);
  };
  const auto backend = MakeTaskBackend(task);
  PredictionOptions options = MakeOptions(task, *backend, control);
  const MaterialSource materials = ReadMaterialSource(task.folder, backend->model(), options.seed);
  const Stopwatch watch;
  report(0.0, "prediction");
  std::vector<PredictedDrape> drapes = SampleDrapes(*backend, materials, options);
  const double seconds = watch.Seconds();
  if (control.cancelled()) return {};
  json calibrated = json::object();
  if (task.calibrate) {
    AddAsFitted(drapes, *task.held_out, &calibrated);
    const BendCalibration calibration =
        CalibrateBend(*backend, materials, options, *task.training, {}, [&](int trials) {
          report(std::min(0.9, 0.3 + 0.6 * trials / kUsualTrials), "calibration");
        });
    if (calibration.cancelled) return {};
    options.bend = calibration.factors;
    calibrated["bend_factor_up"] = calibration.factors.up;
    calibrated["bend_factor_down"] = calibration.factors.down;
    calibrated["calibration_seconds"] = watch.Seconds() - seconds;
    report(0.9, "prediction");
    drapes = SampleDrapes(*backend, materials, options);
    if (control.cancelled()) return {};
  }
  AddScores(drapes, *task.held_out, &result);
  if (result.contains("failure")) return result;
  result["numbers"].update(calibrated);
  result["numbers"]["prediction_seconds"] = seconds;
  return result;
}

std::optional<json> FitAndPredict(const ExperimentTask& task, const RunControl& control) {
  const FitFiles files{.out = task.folder,
                       .checkpoint = task.checkpoint,
                       .keep_checkpoint = true,
                       .log = task.folder + "/fit.log",
                       .provenance = task.provenance};
  const RunControl part{control.cancel, [&](double fraction, const std::string& note) {
                          control.Report(kFitShare * fraction, note);
                        }};
  if (ContinueFitJob(task.fit, task.data, files, part).cancelled) return {};
  const json summary = ParseJson(ReadOwnFile(task.folder + "/summary.json"), task.folder);
  json result = SummariseFit(summary, task.fit.model);
  if (result.contains("failure")) return result;
  return Predict(task, control, std::move(result));
}

}  // namespace

json SummariseFit(const json& summary, FitModel model) {
  const std::string failure = DescribeFailure(summary, model);
  if (!failure.empty()) return {{"failure", failure}};
  json result = {{"numbers", FitNumbers(summary)}};
  if (summary.contains("posterior"))
    for (const char* key : {"stretch_n_per_m", "bend_n_m"})
      result["posterior"][key] = summary["posterior"].at(key);
  return result;
}

json ScoreNumbers(const DistributionScore& score) {
  json numbers = {{"mean_image_mse", score.mean_image_mse},
                  {"feature_energy", score.feature_energy},
                  {"outline_energy_m", score.outline_energy}};
  AddFeature("dc", score.features[0], &numbers);
  AddFeature("folds", score.features[1], &numbers);
  for (auto each = numbers.begin(); each != numbers.end();)
    each = std::isnan(each->get<double>()) ? numbers.erase(each) : std::next(each);
  return numbers;
}

std::optional<json> RunExperiment(const ExperimentTask& task, const RunControl& control) {
  std::filesystem::create_directories(task.folder);
  return task.learning ? LearnAndPredict(task, control) : FitAndPredict(task, control);
}

}  // namespace drape
