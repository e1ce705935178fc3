// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "solver/job/fit_job.h"
#include "solver/studies/bench/cases/bench_drape.h"
#include "solver/studies/bench/cases/bench_record.h"

namespace drape {

// Runs whose work is a fit.
struct FitBenchOptions {
  FitSpec spec;  // but for what the axes set
  FitData data;
  // The cloth whose silhouette is drawn as the only image of the data; nothing: it is there.
  std::optional<BenchSetting> ground_truth;
  std::vector<std::string> held_out;  // images that are not fitted, on which the drapes are scored
};

// InputError for a setting that a fit cannot have.
void CheckBenchFit(const BenchSetting& setting);

// InputError for images that cannot be read or name the files of a fit.
void CheckBenchImages(const FitBenchOptions& options);

// The silhouette of a drape, as bytes of its coverage. Throws InputError where there is no drape.
std::string RenderGroundTruth(const BenchSetting& setting, const BenchProblem& problem);
void WriteGroundTruth(const std::string& rendered, const std::string& path);

// Runs one fit in this process with its files in a folder of `folder`: seconds, and errors from its
// summary.json, after it has settled. Axes: mesh, law, material (the start tables), h and fall (of
// the seeds), integrator (dynamic or static), backend, threads; model heter_elements and
// heter_modes are fields on each element or in modes, bdp and bayes have draws. Throws InputError.
BenchRecord RunBenchFit(const BenchSetting& setting, const FitBenchOptions& options,
                        const std::string& folder, const std::atomic<bool>* cancel);

}  // namespace drape
