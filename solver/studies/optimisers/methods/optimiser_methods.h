// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "solver/studies/optimisers/methods/budgeted_function.h"
#include "solver/studies/optimisers/methods/search/search_method.h"

// What RunOptimiser calls; each runs until it converges or the meter refuses, and says in a
// sentence why it ended.
namespace drape {

// invalid_steps: trials in a row that cannot be evaluated before it stops; 5 in drape_fit, by
// Ceres's default.
std::string RunLevenbergMarquardt(BudgetedFunction& function, int invalid_steps);
// At most so many rounds of the same from the best point so far (BudgetedFunction::RefineFromBest).
std::string RefineByLevenbergMarquardt(BudgetedFunction& function, int rounds);
// subspace: in the plane of gradient and Gauss–Newton step instead of along the dogleg [Byrd
// 1988].
std::string RunDogleg(BudgetedFunction& function, bool subspace);
std::string RunLbfgs(BudgetedFunction& function);

// [Kingma 2015], with its β. rates: [P]. Adam has no rule for a point that cannot be
// evaluated: it goes back to the best one, with half the rates and its moments forgotten.
std::string RunAdam(BudgetedFunction& function, Eigen::VectorXd rates);

// Proposals of a search until the budget is spent or it converges.
std::string RunSearch(BudgetedFunction& function, SearchMethod& search);
// "cmaes", "bo", "rembo_<d>", "rembo_ucb_<d>", "hesbo_<d>" of OptimiserMethods, for P numbers in
// the box of the options, drawing from their seed.
std::unique_ptr<SearchMethod> MakeSearch(const std::string& name, int size,
                                         const OptimiserOptions& options);

// Of NLopt: "bobyqa", "sbplx", "crs", "direct". Without NLopt in the build: NLoptIsThere is false
// and Run is a programmer error.
bool NLoptIsThere();
std::string RunNLopt(BudgetedFunction& function, const std::string& name,
                     const OptimiserOptions& options);

}  // namespace drape
