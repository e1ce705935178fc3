// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/metrics/metrics_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "losses/metrics/report_json.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMm = 1e-3;
constexpr double kMm2 = 1e-6;
constexpr double kDegree = M_PI / 180;
constexpr char kGreyImage[] = "grey mean image";  // has no outline

std::string TwoNumbers(const char* name, double a, double b) {
  return Format("  %-26s %10.4g %10.4g\n", name, a, b);
}

std::string ShapeText(const ShapeFeatures& a, const ShapeFeatures& b) {
  std::string text = Format("  %-26s %10s %10s\n", "", "A", "B") +
                     TwoNumbers("drape coefficient", a.drape_coefficient, b.drape_coefficient) +
                     TwoNumbers("folds", a.folds, b.folds);
  const char* const bands[] = {"band 2 [mm2]", "band 3-5 [mm2]", "band 6-9 [mm2]",
                               "band 10-15 [mm2]"};
  for (int k = 0; k < kNumBands; ++k)
    text += TwoNumbers(bands[k], a.band_energy[k] / kMm2, b.band_energy[k] / kMm2);
  return text + TwoNumbers("smallest radius [mm]", a.radius_min / kMm, b.radius_min / kMm) +
         TwoNumbers("largest radius [mm]", a.radius_max / kMm, b.radius_max / kMm) +
         TwoNumbers("isoperimetric ratio", a.isoperimetric_ratio, b.isoperimetric_ratio);
}

Json DistanceJson(const DrapeDistance& distance) {
  return {{"mse", distance.mse},
          {"iou", distance.iou},
          {"outline_rms_m", distance.profile_rms},
          {"outline_hausdorff_m", distance.outline_hausdorff}};
}

Json ShapeJson(const ShapeFeatures& shape) {
  return {
      {"dc", shape.drape_coefficient},       {"folds", shape.folds},
      {"band_energy_m2", shape.band_energy}, {"radius_min_m", shape.radius_min},
      {"radius_max_m", shape.radius_max},    {"isoperimetric_ratio", shape.isoperimetric_ratio}};
}

std::string PredictorLine(const PredictorRow& row) {
  std::string text =
      Format("%-26s %6d %8.4f %8.4f", row.name.c_str(), row.pairs, row.mean.mse, row.median.mse);
  if (row.name == kGreyImage) return text + Format(" %7s %8s\n", "-", "-");
  text += Format(" %7.3f %8.2f", row.mean.iou, row.mean.outline_hausdorff / kMm);
  if (row.aligned_mean)
    text +=
        Format(" %9.4f %8.2f", row.aligned_mean->mse, row.aligned_mean->outline_hausdorff / kMm);
  return text + "\n";
}

Json PredictorJson(const PredictorRow& row) {
  Json json = {{"name", row.name}, {"pairs", row.pairs}};
  if (row.name == kGreyImage) {
    json["mean"] = {{"mse", row.mean.mse}};
    json["median"] = {{"mse", row.median.mse}};
    return json;
  }
  json["mean"] = DistanceJson(row.mean);
  json["median"] = DistanceJson(row.median);
  if (row.aligned_mean) json["aligned_mean"] = DistanceJson(*row.aligned_mean);
  return json;
}

}  // namespace

std::string PairText(const ComparedPair& pair) {
  const auto& [raw, aligned, alignment] = pair.comparison;
  std::string text =
      "A " + pair.a + "\nB " + pair.b + "\n" +
      Format("  %-26s %10s %10s\n", "", "as it lies", "aligned") +
      TwoNumbers("silhouette MSE", raw.mse, aligned.mse) +
      TwoNumbers("silhouette IoU", raw.iou, aligned.iou) +
      TwoNumbers("outline rms [mm]", raw.profile_rms / kMm, aligned.profile_rms / kMm) +
      TwoNumbers("outline Hausdorff [mm]", raw.outline_hausdorff / kMm,
                 aligned.outline_hausdorff / kMm);
  if (pair.surfaces)
    text += TwoNumbers("surface Hausdorff [mm]", pair.surfaces->raw / kMm,
                       pair.surfaces->aligned / kMm);
  return text +
         Format("  aligned: B %sturned by %.1f deg counter-clockwise\n",
                alignment.mirrored ? "mirrored (y to -y) and " : "", alignment.rotation / kDegree) +
         ShapeText(pair.shape_a, pair.shape_b);
}

Json PairJson(const ComparedPair& pair) {
  const DrapeComparison& c = pair.comparison;
  Json json = {
      {"a", {{"file", pair.a}, {"shape", ShapeJson(pair.shape_a)}}},
      {"b", {{"file", pair.b}, {"shape", ShapeJson(pair.shape_b)}}},
      {"raw", DistanceJson(c.raw)},
      {"aligned", DistanceJson(c.aligned)},
      {"alignment", {{"rotation_rad", c.alignment.rotation}, {"mirrored", c.alignment.mirrored}}}};
  if (pair.surfaces) {
    json["raw"]["surface_hausdorff_m"] = pair.surfaces->raw;
    json["aligned"]["surface_hausdorff_m"] = pair.surfaces->aligned;
  }
  return json;
}

std::string ScoreText(const DistributionScore& score) {
  std::string text = Format("%-12s %10s %10s %10s %10s %15s %15s\n", "", "observed", "predicted",
                            "sd", "CRPS", "in 50 % (of)", "in 90 % (of)");
  for (int k = 0; k < kNumFeatures; ++k) {
    const FeatureScore& f = score.features[k];
    const double unit = k < 2 ? 1 : kMm2;
    text += Format("%-12s %10.4g %10.4g %10.3g %10.3g %8.2f (%.2f) %8.2f (%.2f)%s\n",
                   kFeatureNames[k], f.observed_mean / unit, f.predicted_mean / unit,
                   f.predicted_sd / unit, f.crps / unit, f.half.coverage, f.half.nominal,
                   f.ninety.coverage, f.ninety.nominal, k < 2 ? "" : "  mm2");
  }
  return text + Format(
                    "MSE of the mean image %.4f, energy score of the features %.3f, of the "
                    "outlines %.2f mm, %d observed\n",
                    score.mean_image_mse, score.feature_energy, score.outline_energy / kMm,
                    score.observed);
}

std::string PredictorsText(const TrivialPredictors& predictors) {
  std::string text = Format("%-26s %6s %8s %8s %7s %8s %9s %8s\n", "predicted by", "pairs", "MSE",
                            "median", "IoU", "H [mm]", "aligned", "H [mm]");
  for (const PredictorRow& row : predictors.rows) text += PredictorLine(row);
  if (predictors.other_samples)
    text += "other samples of the fabric and face, as a distribution\n" +
            ScoreText(*predictors.other_samples);
  if (predictors.circle)
    text += "circle of the mean area, as a distribution\n" + ScoreText(*predictors.circle);
  return text;
}

Json PredictorsJson(const TrivialPredictors& predictors) {
  Json json = {{"rows", Json::array()}};
  for (const PredictorRow& row : predictors.rows) json["rows"].push_back(PredictorJson(row));
  json["other_samples"] =
      predictors.other_samples ? ScoreJson(*predictors.other_samples) : Json(nullptr);
  json["circle"] = predictors.circle ? ScoreJson(*predictors.circle) : Json(nullptr);
  return json;
}

}  // namespace drape
