// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

struct OptimiserMethod {
  std::string name;
  bool derivatives;     // uses Jacobians
  bool available;       // false: this build is without NLopt
  std::string summary;  // what it is, for tables
};
// "lm", "lm_patient", "dogleg", "subspace_dogleg", "lbfgs", "adam_published", "adam_0.03",
// "adam_0.1", and of NLopt "bobyqa", "sbplx", "crs", "direct".
const std::vector<OptimiserMethod>& OptimiserMethods();
// Throws InputError for a name that is not among them, or not available.
const OptimiserMethod& FindOptimiser(const std::string& name);

// Minimises from θ = 0 until the method converges, or the budget or a cancel ends it.
OptimiserRun RunOptimiser(const std::string& name, ResidualFunction& function,
                          const OptimiserOptions& options);

}  // namespace drape
