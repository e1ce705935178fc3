// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

// The images of fits as layers: the picture, its outline, the fitted outline, support and flat
// cloth, with a scale; the numbers of each below. Of an image that cannot be read any more, the
// picture that the fit has written.
void AddImages(const std::vector<ResultFolder>& folders, ReportPage* page);

// The drapes of meshes and of stored branches to turn, coloured by height, stretch and curvature.
void AddDrapes(const std::vector<ResultFolder>& folders, ReportPage* page);

}  // namespace drape
