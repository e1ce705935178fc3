// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

// The drapes of a prediction or of a survey of equilibria from above, side by side: one colour for
// each specimen or branch, drape coefficient and nodes below each, and the shares of the branches.
void AddOutlines(const std::vector<ResultFolder>& folders, ReportPage* page);

}  // namespace drape
