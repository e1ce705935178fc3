// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/bench/bench_chart.h"
#include "solver/studies/bench/bench_job.h"

namespace drape {

// What the runs of a benchmark show together.

// The measure of time of a clock, "wall" or "cpu".
BenchMeasure TimeMeasure(const std::string& clock);

// Errors of the runs of a work; the first is that of the printed table.
std::vector<BenchMeasure> ListErrors(BenchWork work);

// Indices of the runs on the Pareto front of time and an error, fastest first, without runs on
// another branch, not at rest or without a result.
std::vector<int> AccuracyFront(const BenchResult& result, BenchMeasure time, BenchMeasure error);

// One series of runs that differ only in the mesh.
std::vector<GrowthSeries> MakeGrowth(const BenchJob& job, const BenchResult& result,
                                     BenchMeasure time);

// The runs of the smooth law that are at rest on the branch, one series for each backend and batch,
// and the published programs, whose cloth is that of the reference law: their time is that of
// kPublishedSteps steps, their error that of our drape by that law on a mesh of about as many
// vertices, which leaves out errors of their steps. Empty without runs of the reference law.
inline constexpr int kPublishedSteps = 100;
std::vector<CodeSeries> CompareCodes(const BenchResult& result, BenchMeasure time,
                                     const PublishedSpeeds& published);

// front_<error>.png and .svg for each error, growth.png and .svg, and, of drapes where
// job.published has rows, codes.png and .svg, in `folder`.
void RenderBenchCharts(const std::string& folder, const BenchJob& job, const BenchResult& result,
                       BenchMeasure time);

}  // namespace drape
