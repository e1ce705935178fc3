// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solver/studies/optimisers/optimiser_benchmark.h"
#include "solver/studies/optimisers/performance_profile.h"

namespace drape {

// A problem counts as solved at these tolerances (SolvedBelow).
inline constexpr double kHalfTolerance = 0.5, kLooseTolerance = 0.1, kTightTolerance = 0.01;
// A run has reached what Levenberg–Marquardt reaches when its cost is at most so many times that at
// which the method "lm" ended.
inline constexpr double kReachedFactor = 1.1;

// By linear interpolation between order statistics; infinity sorts last. Zeros without values.
struct Quartiles {
  double low = 0.0, median = 0.0, high = 0.0;
};
Quartiles ComputeQuartiles(std::vector<double> values);

// The problems with so many free numbers.
OptimiserBenchmark SelectProblems(const OptimiserBenchmark& benchmark, int parameters);

// A method over all problems and seeds. A method without seeds counts as often as the others.
struct MethodScore {
  std::string method;
  double solved_loose = 0.0, solved_tight = 0.0;  // shares of the runs
  double wins = 0.0;         // share that ends within 0.1 % of the least cost of any run
  double best_branch = 0.0;  // share whose drape lies within the tolerance of the best run's
  Quartiles gap = {};        // (cost − best)/(start − best) at the end
  double mean_rms_px = 0.0, mean_settled_rms_px = 0.0;  // over the runs with a drape
  double largest_coupling = 0.0;                        // of all its tables, c12²/(c11·c22)
  double failed = 0.0;                                  // share of the evaluations
  double median_seconds = 0.0;                          // CPU, of a run
  double median_own_seconds = 0.0;  // of them, outside the function: the method's own work
};
std::vector<MethodScore> ScoreMethods(const OptimiserBenchmark& benchmark, double branch_tolerance);

// What each run spent to solve its problem, shape [problems·seeds, methods], seed fastest.
Eigen::MatrixXd SpentToSolve(const OptimiserBenchmark& benchmark, double tolerance,
                             BudgetUnit unit);
// What each run spent to reach kReachedFactor, of the same shape; empty without the method "lm".
Eigen::MatrixXd SpentToReachLm(const OptimiserBenchmark& benchmark);

// CPU seconds of a Jacobian by those of an evaluation, over all runs with both; 0 without.
double MeasuredJacobianCost(const OptimiserBenchmark& benchmark);

// Of the gap (cost − best)/(start − best) once `spent` of the budget is used, over problems and
// seeds.
Quartiles GapsAt(const OptimiserBenchmark& benchmark, int method, double spent);

}  // namespace drape
