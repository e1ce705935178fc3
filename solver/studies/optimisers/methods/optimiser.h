// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

struct OptimiserMethod {
  std::string name;
  bool derivatives;         // uses Jacobians from the start
  bool available;           // false: this build is without NLopt
  std::string summary;      // what it is, for tables
  bool random = false;      // draws random numbers: runs with other seeds differ
  bool by_default = true;   // runs where no methods are named
  std::string search = {};  // of "<search>_lm": the method that its last rounds refine
};

// Rounds of Levenberg–Marquardt that refine the best point of a search in "<search>_lm", and what
// is kept of the budget for them: each round and the evaluation of that point with a Jacobian.
inline constexpr int kRefiningRounds = 20;
double RefiningBudget(const OptimiserOptions& options);

// "lm", "lm_patient", "dogleg", "subspace_dogleg", "lbfgs", "adam_published", "adam_0.03",
// "adam_0.1"; of NLopt "bobyqa", "sbplx", "crs", "direct"; "cmaes", "bo", and through embeddings of
// d = 2, 4, 8 numbers "rembo_<d>", "hesbo_<d>", also "rembo_ucb_4"; and each without derivatives
// again with the ending "_lm".
const std::vector<OptimiserMethod>& OptimiserMethods();
// Throws InputError for a name that is not among them, or not available.
const OptimiserMethod& FindOptimiser(const std::string& name);

// Minimises from θ = 0 until the method converges, or the budget or a cancel ends it.
OptimiserRun RunOptimiser(const std::string& name, ResidualFunction& function,
                          const OptimiserOptions& options);

}  // namespace drape
