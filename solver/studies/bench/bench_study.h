// SPDX-License-Identifier: Apache-2.0
#pragma once

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
// reference fails. The result of a fit is its time and, from its summary.json, its errors after it
// has settled; its files are in OUT/fits/<id of the cell>. The result of another work is that of
// RunBenchSetting. Reads and checks all input. Throws InputError.
//
// Axes of a fit: mesh, law, material (the start tables), h and relax_time (of the initial guesses),
// integrator (dynamic or static), backend, threads; the models heterogeneous_elements and
// heterogeneous_modes are fields on each element or in modes, bdp and bayes have draws.
Study MakeBenchStudy(const BenchJob& job);

}  // namespace drape
