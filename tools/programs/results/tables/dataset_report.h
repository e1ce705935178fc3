// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "losses/dataset/dataset_evaluation.h"

namespace drape {

// A data set, its split and its trivial predictors: tables for a terminal, JSON in SI units.
std::string DatasetText(const DatasetReport& report);
nlohmann::ordered_json DatasetJson(const DatasetReport& report);

}  // namespace drape
