// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

// Photographs with what was found in them, and what drape_metrics has measured or compared.
void AddMeasurements(const std::vector<ResultFolder>& folders, ReportPage* page);

// Fabrics for other programs: the linear record, and of each target what is lost and how the fabric
// drapes with what is left.
void AddExports(const std::vector<ResultFolder>& folders, ReportPage* page);

}  // namespace drape
