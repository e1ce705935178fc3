// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/metrics/metrics_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/text_format.h"
#include "tools/programs/reports/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMm = 1e-3;
constexpr double kMm2 = 1e-6;
constexpr double kDegree = M_PI / 180;

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

Json ShapeJson(const ShapeFeatures& shape) {
  return {
      {"dc", shape.drape_coefficient},       {"folds", shape.folds},
      {"band_energy_m2", shape.band_energy}, {"radius_min_m", shape.radius_min},
      {"radius_max_m", shape.radius_max},    {"isoperimetric_ratio", shape.isoperimetric_ratio}};
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

}  // namespace drape
