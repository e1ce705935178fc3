// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/util/run_control.h"
#include "solver/studies/optimisers/optimiser_benchmark.h"
#include "tools/cli/option_table.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable OptimiserBenchmarkTable(OptimiserBenchmarkOptions& options);

// The names of the runs of options.cells (ListOptimiserCells), one a line. Throws InputError.
std::string ListOptimiserText(const OptimiserBenchmarkOptions& options);

// RunOptimiserBenchmark, whose reports appear in options.out together at the end. Throws
// InputError.
OptimiserBenchmark RunBenchmarkTool(OptimiserBenchmarkOptions options, const RunControl& control);

// The program drape_compare_optimisers.
int CompareOptimisersMain(int argc, char** argv);

}  // namespace drape
