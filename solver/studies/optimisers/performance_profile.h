// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

// How methods compare over many problems [Dolan 2002; More 2009].

// What was spent when the cost first was ≤ target: budget, or CPU seconds. Infinity when never.
enum class BudgetUnit { kBudget, kSeconds };
double SpentToReach(const std::vector<TracePoint>& trace, double target, BudgetUnit unit);

// Solved: cost ≤ best + tolerance·(start − best), where best is the least that any method reached.
double SolvedBelow(double start, double best, double tolerance);

// Of [problems, methods] what each spent to solve: divided by the least of its problem. Infinity
// stays; a problem that none solved is a row of infinities.
Eigen::MatrixXd PerformanceRatios(const Eigen::MatrixXd& spent);

// Share of the problems that a method (a column of ratios) solved within `factor` of the best.
double ProfileAt(const Eigen::VectorXd& ratios, double factor);

// The profile as a staircase: where it rises, ascending, and its value from there on. Begins with
// factor 1.
struct ProfileStep {
  double factor = 1.0;
  double share = 0.0;
};
std::vector<ProfileStep> ProfileSteps(const Eigen::VectorXd& ratios);

}  // namespace drape
