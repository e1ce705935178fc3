// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/measure/metrics/metrics_report.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "losses/metrics/laboratory_drape.h"
#include "losses/metrics/metrics.h"
#include "physics/util/text_format.h"
#include "tools/programs/results/tables/score_report.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMm = 1e-3;
constexpr double kMm2 = 1e-6;
constexpr double kCm2 = 1e-4;
constexpr double kDegree = M_PI / 180;
constexpr const char* kSheetTitle = "The drape, as laboratories report it";

std::string TwoNumbers(const char* name, double a, double b) {
  return Format("  %-26s %10.4g %10.4g\n", name, a, b);
}

// A feature as tables and CSV files show it.
struct FeatureColumn {
  const char* name;  // with its unit
  const char* key;   // of a CSV column
  double (*value)(const ShapeFeatures& shape);
};
constexpr FeatureColumn kFeatureColumns[] = {
    {"drape coefficient", "dc", [](const ShapeFeatures& s) { return s.drape_coefficient; }},
    {"folds", "folds", [](const ShapeFeatures& s) { return double(s.folds); }},
    {"band 2 [mm2]", "band_2_mm2", [](const ShapeFeatures& s) { return s.band_energy[0] / kMm2; }},
    {"band 3-5 [mm2]", "band_3_5_mm2",
     [](const ShapeFeatures& s) { return s.band_energy[1] / kMm2; }},
    {"band 6-9 [mm2]", "band_6_9_mm2",
     [](const ShapeFeatures& s) { return s.band_energy[2] / kMm2; }},
    {"band 10-15 [mm2]", "band_10_15_mm2",
     [](const ShapeFeatures& s) { return s.band_energy[3] / kMm2; }},
    {"smallest radius [mm]", "radius_min_mm",
     [](const ShapeFeatures& s) { return s.radius_min / kMm; }},
    {"largest radius [mm]", "radius_max_mm",
     [](const ShapeFeatures& s) { return s.radius_max / kMm; }},
    {"isoperimetric ratio", "isoperimetric_ratio",
     [](const ShapeFeatures& s) { return s.isoperimetric_ratio; }}};

std::string ShapeText(const ShapeFeatures& a, const ShapeFeatures& b) {
  std::string text = Format("  %-26s %10s %10s\n", "", "A", "B");
  for (const FeatureColumn& column : kFeatureColumns)
    text += TwoNumbers(column.name, column.value(a), column.value(b));
  return text;
}

Json ShapeJson(const ShapeFeatures& shape) {
  return {
      {"dc", shape.drape_coefficient},       {"folds", shape.folds},
      {"band_energy_m2", shape.band_energy}, {"radius_min_m", shape.radius_min},
      {"radius_max_m", shape.radius_max},    {"isoperimetric_ratio", shape.isoperimetric_ratio}};
}

std::string CameraLine(const MeasuredDrape& drape) {
  if (!drape.quality) return "a mesh, seen from above";
  return CameraText(drape.camera, *drape.quality);
}

std::string CsvText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string JoinedNotes(const MeasuredDrape& drape) {
  std::string text;
  if (!drape.quality) return text;
  for (const std::string& note : drape.quality->notes) text += (text.empty() ? "" : "; ") + note;
  return text;
}

}  // namespace

std::string MeasuredText(const MeasuredDrape& drape) {
  const auto line = [](const char* name, double value) {
    return Format("  %-26s %10.4g\n", name, value);
  };
  std::string text =
      drape.file + "\n  " + CameraLine(drape) + "\n" +
      Format("  %-26s %10.1f\n", "drape coefficient [%]", 100 * drape.shape.drape_coefficient) +
      line("area [cm2]", drape.area / kCm2) + line("mean radius [mm]", drape.mean_radius / kMm);
  for (const FeatureColumn& column : kFeatureColumns)
    text += line(column.name, column.value(drape.shape));
  text += SheetText(DrapeSheet(drape.laboratory, kSheetTitle));
  if (!drape.quality) return text;
  for (const std::string& note : drape.quality->notes) text += "  note: " + note + "\n";
  return text;
}

std::string MeasuredTable(const std::vector<MeasuredDrape>& drapes) {
  std::string text = Format("%-32s %8s %6s %10s %18s %8s  %s\n", "file", "DC [%]", "folds",
                            "area [cm2]", "radius [mm]", "px/m", "notes");
  for (const MeasuredDrape& drape : drapes) {
    const std::string name = std::filesystem::path(drape.file).filename();
    if (!drape.error.empty()) {
      text += Format("%-32s ", name.c_str()) + "not measured: " + drape.error + "\n";
      continue;
    }
    text += Format("%-32s %8.1f %6d %10.1f %8.1f … %-8.1f %7.1f  ", name.c_str(),
                   100 * drape.shape.drape_coefficient, drape.shape.folds, drape.area / kCm2,
                   drape.shape.radius_min / kMm, drape.shape.radius_max / kMm,
                   drape.camera.pixels_per_metre()) +
            JoinedNotes(drape) + "\n";
  }
  return text;
}

std::string MeasuredCsv(const std::vector<MeasuredDrape>& drapes) {
  std::string text = "file,";
  for (const FeatureColumn& column : kFeatureColumns) text += std::string(column.key) + ",";
  text += "area_cm2,radius_mean_mm,centre_column_px,centre_row_px,px_per_m,";
  for (const LaboratoryRow& row : DrapeSheet({}, "").rows) text += row.key + ",";
  text += "notes,error\n";
  for (const MeasuredDrape& drape : drapes) {
    text += CsvText(drape.file) + ",";
    const bool measured = drape.error.empty();
    const auto add = [&](double value) { text += measured ? Format("%.6g,", value) : ","; };
    for (const FeatureColumn& column : kFeatureColumns) add(column.value(drape.shape));
    for (const double value : {drape.area / kCm2, drape.mean_radius / kMm, drape.camera.cx,
                               drape.camera.cy, drape.camera.pixels_per_metre()})
      add(value);
    for (const LaboratoryRow& row : DrapeSheet(drape.laboratory, "").rows) add(row.value);
    text += CsvText(JoinedNotes(drape)) + "," + CsvText(drape.error) + "\n";
  }
  return text;
}

Json MeasuredJson(const MeasuredDrape& drape) {
  Json json = {{"file", drape.file}};
  if (!drape.error.empty()) {
    json["error"] = drape.error;
    return json;
  }
  json["shape"] = ShapeJson(drape.shape);
  json["area_m2"] = drape.area;
  json["radius_mean_m"] = drape.mean_radius;
  json["laboratory"] = DrapeSheetJson(drape.laboratory, kSheetTitle);
  json["camera"] = CameraJson(drape.camera);
  if (drape.quality) json["quality"] = QualityJson(*drape.quality);
  return json;
}

std::string PairText(const ComparedPair& pair) {
  const auto& [raw, aligned, alignment] = pair.comparison;
  std::string notes;
  for (const std::string& note : pair.notes) notes += "  note: " + note + "\n";
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
         ShapeText(pair.shape_a, pair.shape_b) + notes;
}

Json PairJson(const ComparedPair& pair) {
  const DrapeComparison& c = pair.comparison;
  Json json = {
      {"a", {{"file", pair.a}, {"shape", ShapeJson(pair.shape_a)}}},
      {"b", {{"file", pair.b}, {"shape", ShapeJson(pair.shape_b)}}},
      {"raw", DistanceJson(c.raw)},
      {"aligned", DistanceJson(c.aligned)},
      {"alignment", {{"rotation_rad", c.alignment.rotation}, {"mirrored", c.alignment.mirrored}}},
      {"notes", pair.notes}};
  if (pair.surfaces) {
    json["raw"]["surface_hausdorff_m"] = pair.surfaces->raw;
    json["aligned"]["surface_hausdorff_m"] = pair.surfaces->aligned;
  }
  return json;
}

}  // namespace drape
