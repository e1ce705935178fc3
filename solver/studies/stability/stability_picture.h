// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/stability/stability_atlas.h"

namespace drape {

// PNG: one square for each run, coloured by its outcome, in the order of Cases(); a missing run
// (kNoRun) is white. `line` may be empty. Throws InputError as WritePicture.
void RenderStabilityMap(const std::string& path, const StabilityMap& map,
                        const std::vector<int>& outcomes, const StabilityLine& line);

// PNG: a matrix of methods by hardships, each cell the share of runs that settle, coloured, with
// the letter of the most frequent failure. Throws InputError as WritePicture.
void RenderStabilityOverview(const std::string& path, const StabilityAtlas& atlas);

}  // namespace drape
