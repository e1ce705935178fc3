// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "losses/metrics/comparison.h"
#include "losses/outline/shape_features.h"

namespace drape {

// How drape_metrics says what it found: tables for a terminal (mm, mm²), JSON in SI units.

struct ComparedPair {
  std::string a, b;  // paths
  DrapeComparison comparison;
  std::optional<SurfaceDistance> surfaces;  // of two meshes
  ShapeFeatures shape_a, shape_b;
};
std::string PairText(const ComparedPair& pair);
nlohmann::ordered_json PairJson(const ComparedPair& pair);

}  // namespace drape
