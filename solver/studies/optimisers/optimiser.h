// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// One cost, many optimisers, equal budgets: what a method reaches for so many evaluations. Knows
// nothing of cloth.

// r(θ) of the cost ½‖r‖².
class ResidualFunction {
 public:
  virtual ~ResidualFunction() = default;
  virtual int size() const = 0;           // P
  virtual int num_residuals() const = 0;  // m
  // residual: [m]; jacobian: nullptr, or ∂r/∂θ, shape [m, P]. False where it cannot be evaluated.
  virtual bool Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                        RowMatrix* jacobian) = 0;
  // The cost of the last evaluation without a Jacobian: 0 if it was refused before any work.
  virtual double cost_units() const { return 1.0; }
  // A method with derivatives takes over at the best point so far.
  virtual void RefineFromBest() {}
};

struct OptimiserOptions {
  double budget = 150.0;             // in evaluations without a Jacobian, > 0
  double jacobian_cost_units = 1.0;  // of a Jacobian beside the evaluation at its point, ≥ 0
  Eigen::VectorXd published_rates;   // of Adam, for "adam_published", shape [P]
  int seed = 1;                      // of methods that draw random numbers
  std::vector<std::string> search_command;    // starts search.py, for the methods that it has
  const std::atomic<bool>* cancel = nullptr;  // ends the run when it turns true
};

// A point where the cost fell.
struct TracePoint {
  double spent = 0.0;    // of the budget, this evaluation included
  double seconds = 0.0;  // CPU time of this thread since the start of the run
  double cost = 0.0;
};

struct OptimiserRun {
  std::string end;  // why it ended: a sentence
  bool cancelled = false;
  std::vector<TracePoint> trace;  // the first is the start, costs fall; empty where it failed
  Eigen::VectorXd theta;          // of the least cost
  double cost = std::numeric_limits<double>::infinity();
  double spent = 0.0;
  double seconds = 0.0;           // as in TracePoint
  double jacobian_seconds = 0.0;  // of them, for Jacobians
  double function_seconds = 0.0;  // of them, for all evaluations; the rest is the method's own work
  int evaluations = 0, jacobians = 0, failed = 0;
};

// A function behind a meter: counts, times and ends what a method may spend. The evaluation that
// crosses the budget is finished; those after it are refused, and so are all after ten
// evaluations for each one that the budget allows, since some may be free.
class BudgetedFunction {
 public:
  BudgetedFunction(ResidualFunction& function, const OptimiserOptions& options);

  int size() const { return function_.size(); }
  int num_residuals() const { return function_.num_residuals(); }
  // Computes and pays only what is missing at the point of the previous call. False where the
  // function fails or nothing is left to spend.
  bool Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual, RowMatrix* jacobian);
  bool exhausted() const;
  // Lets a phase of a method spend so much of the budget in all, or again the whole of it.
  void LimitTo(double spent) { limit_ = spent; }
  // ResidualFunction::RefineFromBest; the next evaluation is paid for, also at the last point.
  void RefineFromBest();
  // Counts CPU time that the method spent in another process.
  void AddSeconds(double seconds) { start_ -= seconds; }
  const OptimiserRun& run() const { return run_; }

 private:
  // The function's, timed.
  bool Call(RowMatrix* jacobian);
  bool EvaluateResidual(const Eigen::VectorXd& theta);
  bool EvaluateJacobian();
  void Record(double cost);

  ResidualFunction& function_;
  const OptimiserOptions& options_;
  double start_, limit_;
  Eigen::VectorXd theta_, residual_;  // of the last call
  RowMatrix jacobian_;
  bool valid_ = false;
  OptimiserRun run_;
};

struct OptimiserMethod {
  std::string name;
  bool derivatives;         // uses Jacobians from the start
  bool random = false;      // draws random numbers: runs with other seeds differ
  bool by_default = true;   // runs where no methods are named
  std::string search = {};  // of "<search>_lm": the method that its last rounds refine
};

// Rounds of Levenberg–Marquardt that refine the best point of a search in "<search>_lm". So much of
// the budget is kept for them: each round and the evaluation of that point with a Jacobian.
inline constexpr int kRefiningRounds = 20;

// Methods with derivatives: "lm" (Levenberg–Marquardt by Ceres, the steps of drape_fit),
// "lm_patient" (50 instead of 5 invalid steps in a row), "dogleg" (Powell's), "subspace_dogleg"
// [Byrd 1988], "lbfgs" (with a Wolfe line search), "adam_published" (learning rates of the
// published experiments), "adam_0.03", "adam_0.1" (rates in log units). By NLopt: "bobyqa",
// "sbplx", "crs" (CRS2), "direct" (DIRECT-L). By OptimiserOptions::search_command: "cmaes", "bo",
// and through embeddings of d = 2, 4, 8 numbers "rembo_<d>", "hesbo_<d>", also "rembo_ucb_4" with
// the settings of REMBO's first publication. Each method without derivatives again with the ending
// "_lm".
const std::vector<OptimiserMethod>& OptimiserMethods();
// Throws InputError for a name that is not among them.
const OptimiserMethod& FindOptimiser(const std::string& name);

// Throws InputError where a search script that one of the methods needs cannot run.
void CheckSearchScript(const std::vector<std::string>& names, const OptimiserOptions& options);

// Minimises from θ = 0 until the method converges, or the budget or a cancel ends it. Throws
// InputError where the search script cannot run.
OptimiserRun RunOptimiser(const std::string& name, ResidualFunction& function,
                          const OptimiserOptions& options);

}  // namespace drape
