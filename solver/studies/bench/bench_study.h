// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "solver/studies/bench/cases/bench_fit.h"
#include "solver/studies/bench/work_precision.h"
#include "solver/studies/runner/study.h"

namespace drape {

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
