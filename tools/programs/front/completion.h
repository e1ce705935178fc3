// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace drape {

// What a program says of itself.
struct ProgramTable {
  std::string verb;
  nlohmann::json table;  // TableJson
};

// A script for bash that completes the verbs of drapefit, and the options, their choices and the
// files of drapefit and of all programs. `front`: the table of drapefit itself (TableJson).
std::string BashCompletion(const nlohmann::json& front, const std::vector<ProgramTable>& programs);

}  // namespace drape
