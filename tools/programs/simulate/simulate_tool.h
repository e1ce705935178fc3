// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/programs/simulate/simulate_result.h"

namespace drape {

// Reads and checks all input before it computes. Writes to options.out summary.json and, of the
// last good shape, drape.obj, silhouette.png and the states asked for; a failed or cancelled run
// writes its last good state too. Throws InputError; earlier results are then unchanged.
SimulateResult RunSimulate(const SimulateOptions& options, const RunControl& control);

// Sets the options that the user has not given from --accuracy and says in one line what was picked
// and which error to expect; empty without --accuracy. Throws InputError for an accuracy that the
// table does not have, or for another scene than the drape test.
std::string ApplyAccuracy(SimulateOptions* options);

// Points into `options`, which outlives it.
OptionTable SimulateTable(SimulateOptions& options);

// The program drape_simulate.
int SimulateMain(int argc, char** argv);

}  // namespace drape
