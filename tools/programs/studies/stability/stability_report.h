// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/programs/studies/stability/stability_result.h"

namespace drape {

// One row per map: how many of its runs ended in each class; then the limits of the explicit method
// and the damping of the implicit ones, theory beside measurement.
std::string StabilityTableText(const StabilityAtlas& atlas);

// The same as JSON, with the axes of the maps. Throws InputError when the file cannot be written.
void WriteStabilityFindings(const std::string& path, const StabilityOptions& options,
                            const StabilityAtlas& atlas);

}  // namespace drape
