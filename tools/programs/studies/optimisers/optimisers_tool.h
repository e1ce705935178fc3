// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/job/fit_job.h"
#include "solver/studies/optimisers/optimiser_problem.h"
#include "solver/studies/optimisers/optimiser_record.h"
#include "tools/cli/option_table.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable OptimiserBenchmarkTable(OptimiserBenchmarkOptions& options);

struct OptimiserBenchmark {
  bool cancelled = false;
  std::vector<std::string> methods;
  std::vector<std::string> problems;     // those that all methods ran on, in order
  std::vector<BenchmarkRecord> records;  // shape [problems · methods], method fastest
  std::vector<std::string> notes;        // problems left out, and why
};

// Runs each method on each problem: an image (real, or the silhouette of a twin) with 2, 7 or 39
// free numbers, from the best seed of the grid as RunStagedFit finds it. Runs are kept in out/runs
// and not repeated; the reports appear in `out` at the end, on a cancel with the problems that are
// complete. Throws InputError.
OptimiserBenchmark RunOptimiserBenchmark(const OptimiserBenchmarkOptions& options,
                                         const RunControl& control);

}  // namespace drape
