// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/predict/predict_report.h"

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "losses/metrics/ensemble_scores.h"
#include "losses/metrics/report_json.h"
#include "physics/util/text_format.h"
#include "solver/forward/random_drapes.h"
#include "tools/cli/provenance.h"
#include "tools/programs/results/tables/dataset_report.h"
#include "tools/programs/results/tables/outline_list.h"
#include "tools/programs/results/tables/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// Of one feature over the drapes at rest; at least two.
struct FeatureDistribution {
  Spread spread;
  CentralInterval half, ninety;
};

FeatureDistribution MakeDistribution(const PredictionRun& run, int feature) {
  std::vector<double> values;
  for (const ObservedDrape* drape : ObservedDrapes(run.drapes, ClothFace::kUnknown))
    values.push_back(ComputeFeatures(drape->shape)[feature]);
  return {SpreadOfValues(values), ComputeInterval(values, 0.5), ComputeInterval(values, 0.9)};
}

std::string FeaturesText(const PredictionRun& run) {
  if (run.at_rest() < 2) return "";
  std::string text = Format("%-12s %10s %10s %23s %23s\n", "", "mean", "sd", "50 % in", "90 % in");
  for (int k = 0; k < kNumFeatures; ++k) {
    const FeatureDistribution d = MakeDistribution(run, k);
    const bool is_band = k >= kNumFeatures - kNumBands;
    const double unit = is_band ? 1e-6 : 1.0;
    text += Format("%-12s %10.4g %10.3g %10.4g … %10.4g %10.4g … %10.4g%s\n", kFeatureNames[k],
                   d.spread.mean / unit, d.spread.sd / unit, d.half.low / unit, d.half.high / unit,
                   d.ninety.low / unit, d.ninety.high / unit, is_band ? "  mm2" : "");
  }
  return text;
}

// Why draws have no drape, and how many.
std::map<std::string, int> Failures(const PredictionRun& run) {
  std::map<std::string, int> counts;
  for (const PredictedDrape& drape : run.drapes)
    if (!drape.seen) ++counts[drape.status];
  return counts;
}

Json IntervalJson(const CentralInterval& interval) {
  return {{"nominal", interval.nominal}, {"low", interval.low}, {"high", interval.high}};
}

Json FeaturesJson(const PredictionRun& run) {
  if (run.at_rest() < 2) return nullptr;
  Json json;
  for (int k = 0; k < kNumFeatures; ++k) {
    const FeatureDistribution d = MakeDistribution(run, k);
    json[kFeatureNames[k]] = {{"mean", d.spread.mean},
                              {"sd", d.spread.sd},
                              {"interval_50", IntervalJson(d.half)},
                              {"interval_90", IntervalJson(d.ninety)}};
  }
  return json;
}

Json DrapeJson(const PredictedDrape& drape) {
  Json json = {{"specimen", drape.specimen + 1},   {"face", ClothFaceName(drape.face)},
               {"repeat", drape.repeat + 1},       {"status", drape.status},
               {"force_residual", drape.residual}, {"newton_iterations", drape.newton_iterations}};
  if (!drape.seen) return json;
  const FeatureVector features = ComputeFeatures(drape.seen->shape);
  for (int k = 0; k < kNumFeatures; ++k) json[kFeatureNames[k]] = features[k];
  return json;
}

Json MaterialJson(const PredictToolOptions& options, const PredictionRun& run) {
  if (options.learn) return {{"learned_from", options.data.folder}};
  if (!options.specimens.empty()) return {{"specimens", options.specimens}};
  if (!options.posterior.empty())
    return {{"posterior", options.posterior}, {"posterior_kind", run.kind}};
  return {{"material", run.scene.material.name}, {"material_file", options.scene.material}};
}

Json SetUpJson(const PredictToolOptions& options, const PredictionRun& run) {
  const PredictionOptions& prediction = run.prediction;
  return {{"draws_wanted", options.draws},
          {"specimens", prediction.specimens},
          {"repeats", prediction.repeats},
          {"face", options.data.face},
          {"seed", prediction.seed},
          {"start_rms_m", prediction.start_rms},
          {"capture_rms_m", prediction.capture_rms},
          {"specimen_stretch_sigma", prediction.specimen_stretch_sigma},
          {"specimen_bend_sigma", prediction.specimen_bend_sigma},
          {"time_step", prediction.settle.steps.h},
          {"steps", prediction.settle.steps.steps},
          {"law", options.scene.law},
          {"mesh", options.scene.mesh},
          {"vertices", run.scene.model->mesh.num_vertices()},
          {"camera", CameraJson(prediction.camera)}};
}

// Means over the resampled distributions and their intervals.
std::string LearnedText(const PredictionRun& run) {
  if (!run.learned) return "";
  const DistributionFit& fit = run.learned->fit;
  std::string text =
      Format("%-32s %10s %10s %23s\n", "specimens", "mean", "deviation", "mean: 90 % in");
  for (int k = 0; k < kSpecimenNumbers; ++k)
    for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown}) {
      if (face == ClothFace::kDown && !DiffersByFace(k)) continue;
      std::vector<double> means;
      for (const SpecimenDistribution& each : fit.resampled) means.push_back(each.mean_of(face)[k]);
      const std::string label =
          NumberRanges()[k].label + (DiffersByFace(k) ? ", " + ClothFaceName(face) : std::string());
      text += Format("%-32s %10.3g %10.2g", label.c_str(), fit.best.mean_of(face)[k],
                     fit.best.deviation[k]);
      if (means.size() >= 2) {
        const CentralInterval ninety = ComputeInterval(means, 0.9);
        text += Format(" %10.3g … %10.3g", ninety.low, ninety.high);
      }
      text += "\n";
    }
  return text + Format(
                    "energy score of the training drapes %.3g, of samples left out %.3g; %.0f "
                    "effective of %d drapes\n",
                    fit.score, fit.cross_validated, fit.effective, fit.drapes);
}

std::string CalibrationText(const PredictionRun& run) {
  if (!run.calibration) return "";
  std::string text = Format("calibrated by %zu trials\n", run.calibration->trials.size());
  for (const ClothFace face : run.prediction.faces) {
    text += Format("  face %s: bend x %.3g\n", ClothFaceName(face).c_str(),
                   run.prediction.bend.of(face));
  }
  return text;
}

Json CalibrationJson(const BendCalibration& calibration) {
  Json json = {{"bend_factor_up", calibration.factors.up},
               {"bend_factor_down", calibration.factors.down},
               {"drapes", calibration.drapes},
               {"trials", Json::array()}};
  for (const BendTrial& trial : calibration.trials)
    json["trials"].push_back({{"face", ClothFaceName(trial.face)},
                              {"bend_factor", trial.factor},
                              {"at_rest", trial.at_rest},
                              {"objective", trial.objective}});
  return json;
}

}  // namespace

std::string PredictionText(const PredictionRun& run) {
  std::string text = CalibrationText(run) + LearnedText(run) +
                     Format("%zu drapes, %d at rest\n", run.drapes.size(), run.at_rest());
  for (const auto& [status, count] : Failures(run))
    text += Format("no drape of %d: ", count) + status + "\n";
  text += FeaturesText(run);
  if (!run.data) return text;
  text += run.score ? "scores on the held-out drapes\n" + ScoreText(*run.score)
                    : "not scored: a held-out face has fewer than two predicted drapes at rest\n";
  return text + DatasetText(*run.data);
}

void WritePredictionSummary(const std::string& path, const PredictToolOptions& options,
                            const PredictionRun& run) {
  Json json = {{"outcome", run.cancelled ? "cancelled" : "done"},
               {"draws", run.drapes.size()},
               {"at_rest", run.at_rest()},
               {"failures", Failures(run)},
               {"backend", run.backend}};
  json.update(SetUpJson(options, run));
  json.update(DiscsJson(run.prediction.discs));
  json.update(MaterialJson(options, run));
  if (run.calibration) json["calibration"] = CalibrationJson(*run.calibration);
  if (run.learned) {
    const DistributionFit& fit = run.learned->fit;
    json["distribution"] = {{"best", DistributionJson(fit.best)},
                            {"energy_training", fit.score},
                            {"energy_cross_validated", fit.cross_validated},
                            {"effective_drapes", fit.effective},
                            {"pool_drapes", fit.drapes}};
  }
  json["features"] = FeaturesJson(run);
  if (run.data) {
    json["score"] = run.score ? ScoreJson(*run.score) : Json(nullptr);
    json["data"] = DatasetJson(*run.data);
  }
  json["drapes"] = Json::array();
  for (const PredictedDrape& drape : run.drapes) json["drapes"].push_back(DrapeJson(drape));
  json["seconds"] = run.seconds;
  WriteWithProvenance(path, std::move(json));
}

void WritePredictedOutlines(const std::string& path, const PredictionRun& run) {
  std::vector<ListedOutline> outlines;
  for (const PredictedDrape& drape : run.drapes) {
    if (!drape.seen) continue;
    const std::string repeat =
        run.prediction.repeats > 1 ? Format(", repeat %d", drape.repeat + 1) : "";
    outlines.push_back(
        {Format("specimen %d, face ", drape.specimen + 1) + ClothFaceName(drape.face) + repeat,
         drape.specimen, drape.seen->shape.drape_coefficient, drape.seen->shape.folds,
         drape.seen->radius});
  }
  WriteOutlines(path, outlines);
}

}  // namespace drape
