// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/studies/optimisers/optimiser_study.h"
#include "tools/cli/option_table.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable OptimiserStudyTable(OptimiserStudyOptions& options);

// The program drape_compare_optimisers.
int CompareOptimisersMain(int argc, char** argv);

}  // namespace drape
