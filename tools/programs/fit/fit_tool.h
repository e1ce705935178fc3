// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/run_control.h"
#include "solver/job/fit_job.h"
#include "tools/inputs/fit_options.h"

namespace drape {

// Runs the fit. The results appear in `out` together at the end; checkpoint.json and fit.log are
// there while it runs. Throws InputError; then earlier results are unchanged.
FitJobResult RunFitTool(const FitToolOptions& options, const RunControl& control);

// The program drape_fit.
int FitMain(int argc, char** argv);

}  // namespace drape
