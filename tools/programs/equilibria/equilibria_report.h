// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/programs/equilibria/equilibria_result.h"

namespace drape {

// One row for each of the largest clusters, then the spread over the drapes and the starts that did
// not come to rest.
std::string EquilibriaTableText(const EquilibriumSurvey& survey);

// Throws InputError when the file cannot be written.
void WriteEquilibriaSummary(const std::string& path, const EquilibriaOptions& options,
                            const LoadedScene& scene, const EquilibriumSurvey& survey);

// Of the drapes at rest in the order of the table, clusters as groups. Throws InputError when the
// file cannot be written.
void WriteEquilibriumOutlines(const std::string& path, const EquilibriumSurvey& survey);

}  // namespace drape
