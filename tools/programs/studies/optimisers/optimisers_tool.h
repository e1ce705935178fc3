// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/run_control.h"
#include "solver/studies/optimisers/optimiser_benchmark.h"
#include "tools/cli/option_table.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable OptimiserBenchmarkTable(OptimiserBenchmarkOptions& options);

// RunOptimiserBenchmark, whose reports appear in options.out together at the end. Throws
// InputError.
OptimiserBenchmark RunBenchmarkTool(OptimiserBenchmarkOptions options, const RunControl& control);

}  // namespace drape
