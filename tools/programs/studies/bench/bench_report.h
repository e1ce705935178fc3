// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/bench/bench_job.h"

namespace drape {

// The measure of time of a clock, "wall" or "cpu".
BenchMeasure TimeMeasure(const std::string& clock);

// Errors that the cells of a work have, the first one for the table of a person.
std::vector<BenchMeasure> ListErrors(BenchWork work);

// Indices of the cells on the Pareto front of time and an error, fastest first; cells on another
// branch or without a result are none.
std::vector<int> AccuracyFront(const BenchResult& result, BenchMeasure time, BenchMeasure error);

// The front of the first error, a line a cell.
std::string BenchTableText(const BenchJob& job, const BenchResult& result, BenchMeasure time);

// bench.json: cells, fronts, exponents of growth, errors of the references, versions.
void WriteBenchJson(const std::string& path, const BenchJob& job, const BenchResult& result,
                    BenchMeasure time);

// front_<error>.png and .svg for each error, growth.png and .svg, in `folder`.
void RenderBenchCharts(const std::string& folder, const BenchJob& job, const BenchResult& result,
                       BenchMeasure time);

}  // namespace drape
