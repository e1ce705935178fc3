// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solver/studies/optimisers/optimiser_benchmark.h"
#include "solver/studies/optimisers/performance_profile.h"

namespace drape {

// A problem counts as solved at these tolerances (SolvedBelow).
inline constexpr double kLooseTolerance = 0.1, kTightTolerance = 0.01;

// A method over all problems.
struct MethodScore {
  std::string method;
  double solved_loose = 0.0, solved_tight = 0.0;  // shares of the problems
  double wins = 0.0;         // share in which it ends within 0.1 % of the least cost
  double best_branch = 0.0;  // share whose drape lies within the tolerance of the best method's
  double median_gap = 0.0;   // (cost − best)/(start − best) at the end
  double mean_rms_px = 0.0, mean_settled_rms_px = 0.0;  // over the problems where it has a drape
  double largest_coupling = 0.0;                        // of all its tables, c12²/(c11·c22)
  double failed = 0.0;                                  // share of the evaluations
  double median_seconds = 0.0;                          // CPU, of a run
};
std::vector<MethodScore> ScoreMethods(const OptimiserBenchmark& benchmark, double branch_tolerance);

// What each method spent to solve each problem, shape [problems, methods].
Eigen::MatrixXd SpentToSolve(const OptimiserBenchmark& benchmark, double tolerance,
                             BudgetUnit unit);

// CPU seconds of a Jacobian by those of an evaluation, over all runs with both; 0 without.
double MeasuredJacobianCost(const OptimiserBenchmark& benchmark);

// Median over the problems of the gap (cost − best)/(start − best) once `spent` of the budget is
// used.
double MedianGapAt(const OptimiserBenchmark& benchmark, int method, double spent);

}  // namespace drape
