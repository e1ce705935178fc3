// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/programs/equilibria/equilibria_result.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable EquilibriaTable(EquilibriaOptions& options);

// Reads all input before it computes. Writes to options.out summary.json, outlines.json and, of
// each cluster, branch_<i>.json, its drape of least energy as a state to start from (i from 1). A
// cancelled run writes what it has. Throws InputError; then what lay in the folder is as it was.
EquilibriumSurvey SurveyEquilibria(const EquilibriaOptions& options, const RunControl& control);

// The program drape_equilibria.
int EquilibriaMain(int argc, char** argv);

}  // namespace drape
