// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "losses/image.h"
#include "tools/branches_tool.h"

namespace drape {

// A row a cluster, then the spread over the drapes and the starts that found no rest.
std::string BranchTableText(const BranchSurvey& survey);

// Throws InputError when the file cannot be written.
void WriteBranchSummary(const std::string& path, const BranchesOptions& options,
                        const LoadedScene& scene, const BranchSurvey& survey);

// A contact sheet of the drapes in the order of the table, clusters as groups.
RgbImage DrawBranches(const BranchSurvey& survey);

}  // namespace drape
