// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/material/material.h"
#include "solver/fit/observed/observation.h"
#include "solver/forward/outline_pool.h"

namespace drape {

// Start tables of images from a pool of simulated drapes [METHODS, P76]: the specimens whose
// drapes are most like the images, at most `count` of them, with that density [kg/m²]. The images
// take turns, each with its next nearest drape. Fewer where images have no closed outline.
std::vector<MaterialField> ListPooledTables(const OutlinePool& pool,
                                            const std::vector<Observation>& observations, int count,
                                            double density);

}  // namespace drape
