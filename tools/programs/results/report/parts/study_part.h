// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

// Of studies: their charts, drawn from the *.chart.json that are beside the pictures, the pictures
// that have none, their reports in Markdown and their tables in CSV.
void AddStudies(const std::vector<ResultFolder>& folders, ReportPage* page);

// Where each result is from: the provenance that its summary has, settings, seconds.
void AddProvenance(const std::vector<ResultFolder>& folders, ReportPage* page);

}  // namespace drape
