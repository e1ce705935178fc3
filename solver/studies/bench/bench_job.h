// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/bench/cases/bench_fit.h"
#include "solver/studies/bench/work_precision.h"

namespace drape {

// All runs of a plan, one after the other, each in a process of its own: what drape_bench does.
struct BenchJob {
  BenchWork work = BenchWork::kForward;
  BenchAxes axes;
  BenchProblem problem;
  ReferenceOptions reference;
  MeasuringOptions measuring;
  FitBenchOptions fit;
  std::string common;   // what all runs have in common, in one line (BenchFile)
  std::string out;      // existing folder: runs.csv, reference_<cloth>.json, fits/
  bool resume = false;  // keep the runs and references that are there
};

struct BenchRun {
  BenchSetting setting;
  BenchRecord record;
};
struct BenchResult {
  bool cancelled = false;      // the runs are those that ended
  std::vector<BenchRun> runs;  // in the order of the plan
  // The errors of the references, estimated, by "material law model".
  std::map<std::string, BenchRecord> reference_errors;
};

// Throws InputError.
BenchResult RunBench(const BenchJob& job, const RunControl& control);

}  // namespace drape
