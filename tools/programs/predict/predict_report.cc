// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/predict/predict_report.h"

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "losses/metrics/laboratory_drape.h"
#include "losses/metrics/metrics.h"
#include "physics/util/text_format.h"
#include "solver/forward/random_drapes.h"
#include "tools/cli/provenance.h"
#include "tools/programs/results/tables/outline_list.h"
#include "tools/programs/results/tables/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

// The distribution of one feature over the drapes at rest; at least two.
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

// The number of samples without a drape, by their reason.
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
  if (options.learn && options.images.images.empty())
    return {{"learned_from", options.data.folder}};
  if (options.learn) return {{"learned_from", options.images.images}};
  if (!options.specimens.empty()) return {{"specimens", options.specimens}};
  return {{"fabric", run.scene.fabric.material.name},
          {"fabric_source", run.scene.fabric.path},
          {"fabric_kind", run.scene.fabric.kind}};
}

// A number that was learned, of one face where the faces differ.
struct LearnedNumber {
  int number = 0;
  std::optional<ClothFace> face;
  double value = 0.0;                     // the best
  std::optional<CentralInterval> ninety;  // over what it can be

  std::string Key() const {
    return NumberRanges()[number].key + (face ? "_" + ClothFaceName(*face) : std::string());
  }
  std::string Label() const {
    const NumberRange& range = NumberRanges()[number];
    return range.label + (face ? ", face " + ClothFaceName(*face) : std::string()) +
           (range.unit[0] == '\0' ? std::string() : std::string(" [") + range.unit + "]");
  }
  // What the pool tells of it, in the unit that a person is shown: an interval that touches an edge
  // of the pool has no end there.
  LaboratoryRow Row() const {
    const NumberRange& range = NumberRanges()[number];
    LaboratoryRow row{.key = Key(), .name = Label(), .value = range.Shown(value)};
    if (!ninety) return row;
    constexpr double kEdge = 0.02;  // of the range
    const double edge = kEdge * (range.high - range.low),
                 infinity = std::numeric_limits<double>::infinity();
    row.interval = {ninety->low < range.low + edge ? -infinity : range.Shown(ninety->low),
                    ninety->high > range.high - edge ? infinity : range.Shown(ninety->high)};
    if (row.is_bound())
      row.value = std::isinf(row.interval->low) ? row.interval->high : row.interval->low;
    return row;
  }
};

LearnedNumber MakeLearnedNumber(int number, ClothFace face, double value,
                                const std::vector<double>& possible) {
  LearnedNumber learned{number, {}, value, {}};
  if (DiffersByFace(number)) learned.face = face;
  if (possible.size() >= 2) learned.ninety = ComputeInterval(possible, 0.9);
  return learned;
}

// The means of specimens, and over the resampled distributions.
std::vector<LearnedNumber> ListMeans(const DistributionFit& fit) {
  std::vector<LearnedNumber> all;
  for (int k = 0; k < kSpecimenNumbers; ++k)
    for (const ClothFace face : {ClothFace::kUp, ClothFace::kDown}) {
      if (face == ClothFace::kDown && !DiffersByFace(k)) continue;
      std::vector<double> means;
      for (const SpecimenDistribution& each : fit.resampled) means.push_back(each.mean_of(face)[k]);
      all.push_back(MakeLearnedNumber(k, face, fit.best.mean_of(face)[k], means));
    }
  return all;
}

// The numbers of one specimen, by its drapes with this face up.
std::vector<LearnedNumber> ListNumbers(const SpecimenPosterior& posterior, ClothFace face) {
  std::vector<LearnedNumber> all;
  for (int k = 0; k < kSpecimenNumbers; ++k) {
    std::vector<double> samples;
    for (const SpecimenNumbers& sample : posterior.samples) samples.push_back(sample[k]);
    all.push_back(MakeLearnedNumber(k, face, posterior.mean[k], samples));
  }
  return all;
}

std::string NumberText(const LearnedNumber& learned, const std::string& varies) {
  const LaboratoryRow row = learned.Row();
  return Format("%-38s %10s %12s %s\n", row.name.c_str(), row.ValueText().c_str(), varies.c_str(),
                row.IntervalText().c_str());
}

std::string SpecimenText(const PredictionRun& run) {
  std::string text;
  for (const auto& [face, posterior] : run.specimen) {
    text += Format("%-38s %10s %12s %23s\n", ("specimen, face " + ClothFaceName(face)).c_str(),
                   "mean", "", "90 % in");
    for (const LearnedNumber& learned : ListNumbers(posterior, face))
      text += NumberText(learned, "");
    if (!posterior.has_like())
      text += Format(
          "no drape of the pool is like it (distance %s, expected at most %.2g): do "
          "not rely on these numbers\n",
          FormatBeyond(posterior.nearest, SpecimenPosterior::kFarthestLike, 1).c_str(),
          SpecimenPosterior::kFarthestLike);
  }
  return text;
}

std::string LearnedText(const PredictionRun& run) {
  if (!run.learned) return "";
  const DistributionFit& fit = run.learned->fit;
  std::string text = SpecimenText(run);
  text += Format("%-38s %10s %12s %23s\n", "specimens", "mean", "they vary by",
                 fit.resampled.empty() ? "" : "mean: 90 % in");
  for (const LearnedNumber& learned : ListMeans(fit)) {
    const double deviation = fit.best.deviation[learned.number];
    text += NumberText(learned, NumberRanges()[learned.number].is_log
                                    ? Format("x %.3g", std::exp(deviation))
                                    : Format("%.2g", deviation));
  }
  return text + Format(
                    "energy score of the training drapes %.3g, of samples left out %.3g; %.0f "
                    "effective of %d drapes\n",
                    fit.score, fit.cross_validated, fit.effective, fit.drapes);
}

// Intervals by the keys of numbers, "log_bending_length_up"; an end at an edge of the pool is null.
Json IntervalsJson(const std::vector<LearnedNumber>& numbers) {
  Json json = Json::object();
  for (const LearnedNumber& learned : numbers) {
    if (!learned.ninety) continue;
    const LaboratoryRow row = learned.Row();
    Json& interval = json[learned.Key()] = IntervalJson(*learned.ninety);
    if (std::isinf(row.interval->low)) interval["low"] = nullptr;
    if (std::isinf(row.interval->high)) interval["high"] = nullptr;
  }
  return json;
}

Json SpecimenJson(const PredictionRun& run) {
  Json json = Json::object();
  for (const auto& [face, posterior] : run.specimen) {
    const std::vector<LearnedNumber> numbers = ListNumbers(posterior, face);
    Json mean = Json::object();
    for (const LearnedNumber& learned : numbers) mean[learned.Key()] = learned.value;
    json[ClothFaceName(face)] = {{"mean", mean},
                                 {"interval_90", IntervalsJson(numbers)},
                                 {"effective_drapes", posterior.effective},
                                 {"like_drapes_of_the_pool", posterior.has_like()}};
  }
  return json;
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

int PredictionRun::at_rest() const {
  return static_cast<int>(ObservedDrapes(drapes, ClothFace::kUnknown).size());
}

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
               {"backend", run.backend},
               {"specimens", run.prediction.specimens},
               {"mesh", options.scene.mesh},
               {"vertices", run.scene.model->mesh.num_vertices()},
               {"camera", CameraJson(run.prediction.camera)}};
  json.update(DiscsJson(run.prediction.discs));
  json.update(MaterialJson(options, run));
  if (run.calibration) json["calibration"] = CalibrationJson(*run.calibration);
  if (run.learned) {
    const DistributionFit& fit = run.learned->fit;
    json["distribution"] = {
        {"best", DistributionJson(fit.best)}, {"mean_interval_90", IntervalsJson(ListMeans(fit))},
        {"energy_training", fit.score},       {"energy_cross_validated", fit.cross_validated},
        {"effective_drapes", fit.effective},  {"pool_drapes", fit.drapes}};
  }
  if (!run.specimen.empty()) json["specimen"] = SpecimenJson(run);
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
