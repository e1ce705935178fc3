// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

// Of fits with a posterior: mean and deviation of each log factor beside the prior's, the densities
// of those that the data narrow most, and pairs of them.
void AddPosteriors(const std::vector<ResultFolder>& folders, ReportPage* page);

// Of drape_predict: intervals of each feature, drape coefficients and numbers of nodes as bars, and
// bands that hold half and 90 % of the outlines.
void AddPredictions(const std::vector<ResultFolder>& folders, ReportPage* page);

// The singular values of each fit with the limit of what the data determine.
void AddSpectra(const std::vector<ResultFolder>& folders, ReportPage* page);

}  // namespace drape
