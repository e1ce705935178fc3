// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/studies/bench/bench_summary.h"

namespace drape {

// The front of the first error, one line per run.
std::string BenchTableText(const BenchJob& job, const BenchResult& result, BenchMeasure time);
// The cloths without a reference and why, one a line.
std::string NoReferencesText(const BenchResult& result);

// bench.json: runs, fronts, exponents of growth, errors of the references, versions.
void WriteBenchJson(const std::string& path, const BenchJob& job, const BenchResult& result,
                    BenchMeasure time);

}  // namespace drape
