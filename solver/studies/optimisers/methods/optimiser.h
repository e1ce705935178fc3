// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

struct OptimiserMethod {
  std::string name;
  bool derivatives;         // uses Jacobians from the start
  bool random = false;      // draws random numbers: runs with other seeds differ
  bool by_default = true;   // runs where no methods are named
  std::string search = {};  // of "<search>_lm": the method that its last rounds refine
};

// Rounds of Levenberg–Marquardt that refine the best point of a search in "<search>_lm", and what
// is kept of the budget for them: each round and the evaluation of that point with a Jacobian.
inline constexpr int kRefiningRounds = 20;
double RefiningBudget(const OptimiserOptions& options);

// Methods that need a box search |θ_i| ≤ kBound.
inline constexpr double kBound = 3.0;

// With derivatives: "lm" (Levenberg–Marquardt by Ceres, the steps of drape_fit), "lm_patient" (50
// instead of 5 invalid steps in a row), "dogleg" (Powell's), "subspace_dogleg" [Byrd 1988], "lbfgs"
// (with a Wolfe line search), "adam_published" (learning rates of the published experiments),
// "adam_0.03", "adam_0.1" (rates in log units). By NLopt: "bobyqa", "sbplx", "crs" (CRS2),
// "direct" (DIRECT-L). By OptimiserOptions::search_command: "cmaes", "bo", and through embeddings
// of d = 2, 4, 8 numbers "rembo_<d>", "hesbo_<d>", also "rembo_ucb_4" with the settings of REMBO's
// first publication. Each method without derivatives again with the ending "_lm".
const std::vector<OptimiserMethod>& OptimiserMethods();
// Throws InputError for a name that is not among them.
const OptimiserMethod& FindOptimiser(const std::string& name);

// Minimises from θ = 0 until the method converges, or the budget or a cancel ends it. Throws
// InputError where the search script cannot run.
OptimiserRun RunOptimiser(const std::string& name, ResidualFunction& function,
                          const OptimiserOptions& options);

// What RunOptimiser calls; each runs until it converges or the meter refuses, and says in a
// sentence why it ended.

// invalid_steps: trials in a row that cannot be evaluated before it stops; 5 in drape_fit, the
// default of Ceres.
std::string RunLevenbergMarquardt(BudgetedFunction& function, int invalid_steps);
// Runs at most so many rounds of the same method from the best point so far
// (BudgetedFunction::RefineFromBest).
std::string RefineByLevenbergMarquardt(BudgetedFunction& function, int rounds);
// subspace: in the plane of gradient and Gauss–Newton step instead of along the dogleg.
std::string RunDogleg(BudgetedFunction& function, bool subspace);
std::string RunLbfgs(BudgetedFunction& function);
std::string RunNLopt(BudgetedFunction& function, const std::string& name, int seed);
// Runs the script in a process of its own, which proposes points and receives their costs.
std::string RunSearch(BudgetedFunction& function, const std::string& name,
                      const OptimiserOptions& options);

}  // namespace drape
