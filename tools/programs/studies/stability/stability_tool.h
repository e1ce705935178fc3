// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/programs/studies/stability/stability_result.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable StabilityTable(StabilityOptions& options);

// Reads all input before it computes. Writes to options.out runs.csv, to which each finished run is
// appended, and at the end findings.json and one PNG per map. A cancelled run renders what it has.
// Throws InputError; then what lay in the folder is as it was.
StabilityAtlas RunStability(const StabilityOptions& options, const RunControl& control);

}  // namespace drape
