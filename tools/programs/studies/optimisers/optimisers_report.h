// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/studies/optimisers/benchmark_scores.h"
#include "tools/cli/output_folder.h"

namespace drape {

// One row per method.
std::string MethodTableText(const OptimiserBenchmark& benchmark, double branch_tolerance);

// All files of the folder.
void WriteBenchmarkReport(const OptimiserBenchmarkOptions& options, const OutputFolder& out,
                          OptimiserBenchmark* benchmark);

}  // namespace drape
