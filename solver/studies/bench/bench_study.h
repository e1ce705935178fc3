// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "solver/job/fit_job.h"
#include "solver/studies/bench/bench_drape.h"
#include "solver/studies/bench/work_precision.h"
#include "solver/studies/runner/study.h"

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

// What drape_bench does.
struct BenchJob {
  BenchWork work = BenchWork::kForward;
  BenchAxes axes;
  BenchProblem problem;
  ReferenceOptions reference;
  MeasuringOptions measuring;
  FitBenchOptions fit;
  nlohmann::json settings = {};              // Study::settings
  std::vector<ReadRecord::File> files = {};  // Study::files
  std::string out;                           // StudyOptions::out
};

// A cell is a run of ListRuns, which is to run in a process of its own (StudyOptions::processes).
// It depends on the reference of its cloth (material, law and model): a cell of a study of its own
// in the same folder, which is found before the first run that needs it. A run whose cloth has no
// reference fails. The result of a fit is that of RunBenchFit, with its files in OUT/fits/<id of
// the cell>, of another work that of RunBenchSetting. Reads and checks all input. Throws
// InputError.
Study MakeBenchStudy(const BenchJob& job);

}  // namespace drape
