// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/programs/studies/stability/stability_result.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable StabilityTable(StabilityOptions& options);

// The names of the runs of options.cells, one a line. Throws InputError.
std::string ListStabilityText(const StabilityOptions& options);

// What a share has to say (ShareText).
std::string StabilityShareText(const StabilityOptions& options, const StabilityAtlas& atlas);

// Reads all input before it computes. Writes to options.out runs.csv, to which each finished run is
// appended, and at the end findings.json and one PNG per map. A cancelled run renders what it has,
// a share nothing. Throws InputError; then what lay in the folder is as it was.
StabilityAtlas RunStability(const StabilityOptions& options, const RunControl& control);

// The program drape_stability.
int StabilityMain(int argc, char** argv);

}  // namespace drape
