// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/studies/optimisers/benchmark_scores.h"
#include "tools/cli/output_folder.h"
#include "tools/programs/results/tables/text_table.h"

namespace drape {

// One row per method.
TextTable MakeMethodTable(const OptimiserBenchmark& benchmark, double branch_tolerance);

// All files of the folder.
void WriteBenchmarkReport(const OptimiserBenchmarkOptions& options, const OutputFolder& out,
                          OptimiserBenchmark* benchmark);

}  // namespace drape
