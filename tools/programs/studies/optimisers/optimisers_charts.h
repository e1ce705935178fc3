// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/studies/optimisers/benchmark_scores.h"
#include "tools/cli/output_folder.h"

namespace drape {

// convergence.png, profiles.png, data_profiles.png, quartiles.png and branches.png. Where methods
// refined by Levenberg–Marquardt are among the others, each group has charts of its own, with "lm"
// in both. Throws InputError without gnuplot.
void WriteBenchmarkPictures(const OptimiserBenchmarkOptions& options,
                            const OptimiserBenchmark& benchmark, const OutputFolder& out);

}  // namespace drape
