// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/programs/front/programs.h"

namespace drape {

// A script for bash that completes the verbs of drapefit, and the options, their choices and the
// files of drapefit and of all programs. `front`: the table of drapefit itself (TableJson).
std::string BashCompletion(const nlohmann::json& front, const std::vector<Program>& programs);

}  // namespace drape
