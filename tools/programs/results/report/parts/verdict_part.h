// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

// What a person may do with the results of each folder, in words, with the warnings first.
void AddVerdicts(const std::vector<ResultFolder>& folders, ReportPage* page);

// What was found of the cloth, in the units of a laboratory, with intervals of 90 % and whether the
// data or the prior say it; one column for each folder that has a fit.
void AddMaterials(const std::vector<ResultFolder>& folders, ReportPage* page);

// One sheet of the block "laboratory" of a summary, of a material or of a drape, as a table.
std::string LaboratoryHtml(const nlohmann::json& sheet);

}  // namespace drape
