// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "losses/dataset/trivial_predictors.h"

namespace drape {

// Distances and scores of drapes: tables for a terminal (mm, mm²), JSON in SI units.
inline constexpr double kMm = 1e-3, kMm2 = 1e-6;

nlohmann::ordered_json DistanceJson(const DrapeDistance& distance);

std::string ScoreText(const DistributionScore& score);

// A data set, its split and its trivial predictors.
std::string DatasetText(const DatasetReport& report);
nlohmann::ordered_json DatasetJson(const DatasetReport& report);

}  // namespace drape
