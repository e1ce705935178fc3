// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "solver/fit_job.h"
#include "tools/optimiser_record.h"
#include "tools/option_table.h"

namespace drape {

// What a user of drape_optimisers sets.
struct OptimisersOptions {
  FitJob job;
  std::vector<std::string> twins;  // fabrics whose drapes are made and fitted
  std::string mesh = "disc:400", coarse_mesh = "disc:200";  // of the job
  std::string twin_mesh = "disc:500";
  int twin_seed = 1;               // of the twins' random starts; the i-th fabric has twin_seed + i
  double twin_hem_rms = 5e-3;      // of the starts [m]
  std::vector<std::string> images;  // real silhouettes (ExpandImages)
  std::vector<std::string> image_materials;  // their start tables: one of each, or one for all
  std::vector<int> parameters = {7, 39};     // Tying
  std::vector<std::string> methods;          // none: all that this build has
  OptimiserOptions race;
  double branch_tolerance = 3e-3;  // drapes nearer than this are one branch [m]
  std::string out;
};

// Points into `options`, which outlives it.
OptionTable OptimisersTable(OptimisersOptions& options);

struct RaceCallbacks {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(double fraction, const std::string& note)> progress;
};

struct Race {
  bool cancelled = false;
  std::vector<std::string> methods;
  std::vector<std::string> problems;  // those that all methods ran on, in order
  std::vector<RaceRecord> records;    // shape [problems · methods], method fastest
  std::vector<std::string> notes;     // problems left out, and why
};

// Runs each method on each problem: an image (real, or the silhouette of a twin) with 2, 7 or 39
// free numbers, from the best seed of the grid as RunStagedFit finds it. Runs are kept in out/runs
// and not repeated; the reports appear in `out` at the end, on a cancel with the problems that are
// complete. Throws InputError.
Race RunRace(const OptimisersOptions& options, const RaceCallbacks& callbacks);

}  // namespace drape
