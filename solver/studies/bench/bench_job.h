// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/bench/cases/bench_fit.h"
#include "solver/studies/bench/speed_table.h"
#include "solver/studies/bench/work_precision.h"
#include "solver/studies/cells/cell_folder.h"
#include "solver/studies/cells/share.h"

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
  std::string out;      // existing folder: runs.csv, reference_<cloth>.json, fits/, cells/
  bool resume = false;  // keep the runs of runs.csv and the references that are there
  // Of the runs; none: all. A share keeps its runs in cells/ and has no runs.csv; a run of all
  // takes the finished ones of cells/ over.
  std::optional<Share> share;
  PublishedSpeeds published = {};  // beside drapes in a chart of their own
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
  // Why there is no reference, in the same way; runs of these cloths have the status
  // kRunNoReference.
  std::map<std::string, std::string> no_references;
};

// The names of the runs in their order (CheckpointKey). Throws InputError.
std::vector<std::string> ListBenchCells(const BenchJob& job);

// Throws InputError. Jobs of other shares may have the same folder at the same time.
BenchResult RunBench(const BenchJob& job, const RunControl& control);

}  // namespace drape
