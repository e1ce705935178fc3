// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "solver/fit/protocol/fit_types.h"

namespace drape {

// The work that a staged fit is expected to take, for the progress line: in time steps of the fine
// cloth, one after the other.
struct FitWork {
  double initial_guesses = 0.0;
  std::vector<double> rounds;  // shape [rounds]

  double total() const;
};

// Rollouts that run on several threads count once; rounds count the iterations that fits usually
// take, not those that they may take.
FitWork ExpectFitWork(const FitProblem& problem, const StagedFitOptions& options);

// The time of a step of a cloth, by that of one of another number of vertices.
double ExpectStepTime(int vertices, int of_vertices);

// The share of an optimisation that its first iterations are, where it usually takes some `usual`
// of them, which is not known before: 0 … 1.
double IterationShare(int iterations, double usual);

}  // namespace drape
