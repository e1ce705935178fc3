// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/measured_image.h"
#include "losses/outline/outline.h"

namespace drape {

// How drape_metrics says what it found: tables for a terminal (mm, mm²), JSON in SI units.

struct ComparedPair {
  std::string a, b;  // paths
  DrapeComparison comparison;
  std::optional<SurfaceDistance> surfaces;  // of two meshes
  ShapeFeatures shape_a, shape_b;
  std::vector<std::string> notes;  // on the images
};
// One drape by itself, or why it could not be measured.
struct MeasuredDrape {
  std::string file;
  std::string error;  // empty: measured
  Camera camera;
  std::optional<ImageQuality> quality;  // of an image
  double area = 0.0;                    // inside the outline [m²]
  double mean_radius = 0.0;             // [m]
  ShapeFeatures shape;
  LaboratoryDrape laboratory;
};
std::string MeasuredText(const MeasuredDrape& drape);
nlohmann::ordered_json MeasuredJson(const MeasuredDrape& drape);
// One line for each drape.
std::string MeasuredTable(const std::vector<MeasuredDrape>& drapes);
// The same as comma-separated values, with a line of names that hold the units.
std::string MeasuredCsv(const std::vector<MeasuredDrape>& drapes);

std::string PairText(const ComparedPair& pair);
nlohmann::ordered_json PairJson(const ComparedPair& pair);

}  // namespace drape
