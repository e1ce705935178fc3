// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/optimisers/optimiser_problem.h"
#include "solver/studies/optimisers/optimiser_record.h"

namespace drape {

struct OptimiserBenchmark {
  bool cancelled = false;
  std::vector<std::string> methods;
  std::vector<std::string> problems;  // those that all methods ran on, in order
  // Of each seed, one of a method that draws no random numbers; shape [problems · methods], method
  // fastest.
  std::vector<std::vector<BenchmarkRecord>> runs;
  std::vector<std::string> notes;   // problems left out, and why
  std::size_t cells = 0, done = 0;  // runs of the share, and how many are complete

  int num_methods() const { return static_cast<int>(methods.size()); }
  int num_problems() const { return static_cast<int>(problems.size()); }
  int num_seeds() const;  // the most that a method has; 0 without problems
  const std::vector<BenchmarkRecord>& Runs(int problem, int method) const {
    return runs[problem * num_methods() + method];
  }
  // Of the seed at that position, 0 … num_seeds − 1; a method without seeds has the same for all.
  const BenchmarkRecord& Record(int problem, int method, int seed) const {
    const std::vector<BenchmarkRecord>& all = Runs(problem, method);
    return all.size() == 1 ? all.front() : all[seed];
  }
  // The run of least cost on a problem.
  const BenchmarkRecord& Best(int problem) const;
  // The cost at the common start of all methods: the first cost of any run.
  double StartCost(int problem) const;
};

// The names of the runs in their order, "synthetic_wool_1_7.bo.seed2": by image, number of
// parameters, method and seed. Throws InputError.
std::vector<std::string> ListOptimiserCells(const OptimiserBenchmarkOptions& options);

// Runs each method on each problem: an image (real, or the silhouette of a twin) with 2, 7 or 39
// free parameters, from the best initial guess of the grid as RunStagedFit finds it. As many runs
// as options.spec.threads at a time, each on one core; results do not depend on it. Runs are kept
// in options.out/runs and not repeated. A cancelled benchmark has the problems that are complete, a
// share (options.cells) has none; runs of other shares may have the same folder at the same time.
// Throws InputError.
OptimiserBenchmark RunOptimiserBenchmark(const OptimiserBenchmarkOptions& options,
                                         const RunControl& control);

}  // namespace drape
