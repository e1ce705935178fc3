// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "solver/job/fit_job.h"
#include "solver/studies/bench/cases/bench_drape.h"

namespace drape {

// Runs whose work is a fit.
struct FitBenchOptions {
  FitSpec spec;  // but for what the axes set
  FitData data;
  // The cloth whose silhouette is drawn as the only image of the data; nothing: it is there.
  std::optional<BenchSetting> ground_truth;
  std::vector<std::string> held_out;  // images that are not fitted, on which the drapes are scored
};

// Reads all that the fit will read. Throws InputError for a file or a setting that a fit cannot
// have.
void CheckBenchFit(const BenchSetting& setting, const FitBenchOptions& options);

// Writes the silhouette of a drape as a PNG. Throws InputError where there is no drape.
void DrawGroundTruth(const BenchSetting& setting, const BenchProblem& problem,
                     const std::string& path);

// Runs one fit in this process with its files in an empty `folder`: seconds, and errors from its
// summary.json, after it has settled. Axes: mesh, law, material (the start tables), h and
// relax_time (of the initial guesses), integrator (dynamic or static), backend, threads; the models
// heterogeneous_elements and heterogeneous_modes are fields on each element or in modes, bdp and
// bayes have draws. Throws InputError.
nlohmann::json RunBenchFit(const BenchSetting& setting, const FitBenchOptions& options,
                           const std::string& folder, const std::atomic<bool>* cancel);

}  // namespace drape
