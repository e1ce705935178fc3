// SPDX-License-Identifier: Apache-2.0
#include <ceres/ceres.h>

#include <algorithm>

#include "solver/fit/fit.h"
#include "solver/studies/optimisers/methods/optimiser.h"

namespace drape {
namespace {

Eigen::VectorXd CopyVector(const double* values, int size) {
  return Eigen::Map<const Eigen::VectorXd>(values, size);
}

class BudgetedCost final : public ceres::CostFunction {
 public:
  explicit BudgetedCost(BudgetedFunction& function) : function_(function) {
    set_num_residuals(function.num_residuals());
    mutable_parameter_block_sizes()->push_back(function.size());
  }
  bool Evaluate(double const* const* theta, double* residuals, double** jacobians) const override {
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    if (!function_.Evaluate(CopyVector(theta[0], function_.size()), &residual,
                            with_jacobian ? &jacobian : nullptr))
      return false;
    std::copy_n(residual.data(), residual.size(), residuals);
    if (with_jacobian) std::copy_n(jacobian.data(), jacobian.size(), jacobians[0]);
    return true;
  }

 private:
  BudgetedFunction& function_;
};

class BudgetedGradient final : public ceres::FirstOrderFunction {
 public:
  explicit BudgetedGradient(BudgetedFunction& function) : function_(function) {}
  int NumParameters() const override { return function_.size(); }
  bool Evaluate(const double* theta, double* cost, double* gradient) const override {
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    if (!function_.Evaluate(CopyVector(theta, function_.size()), &residual,
                            gradient != nullptr ? &jacobian : nullptr))
      return false;
    *cost = 0.5 * residual.squaredNorm();
    if (gradient != nullptr)
      Eigen::Map<Eigen::VectorXd>(gradient, function_.size()) = jacobian.transpose() * residual;
    return true;
  }

 private:
  BudgetedFunction& function_;
};

class StopWhenSpent final : public ceres::IterationCallback {
 public:
  explicit StopWhenSpent(const BudgetedFunction& function) : function_(function) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return function_.exhausted() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const BudgetedFunction& function_;
};

// The options of the last round of a fit.
TrustRegionOptions MakeTrustRegionOptions() {
  TrustRegionOptions options;
  options.max_iterations = 1000000;
  options.cost_tolerance = kLastCostTolerance;
  return options;
}

std::string Solve(BudgetedFunction& function, ceres::Solver::Options options,
                  Eigen::VectorXd theta) {
  StopWhenSpent stop(function);
  options.callbacks.push_back(&stop);
  ceres::Problem problem;
  problem.AddResidualBlock(new BudgetedCost(function), nullptr, theta.data());
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.message;
}

}  // namespace

std::string RunLevenbergMarquardt(BudgetedFunction& function, int invalid_steps) {
  ceres::Solver::Options options = CeresOptions(function.size(), MakeTrustRegionOptions());
  options.max_num_consecutive_invalid_steps = invalid_steps;
  return Solve(function, options, Eigen::VectorXd::Zero(function.size()));
}

std::string RefineByLevenbergMarquardt(BudgetedFunction& function, int rounds) {
  const Eigen::VectorXd best = function.run().theta;
  if (best.size() == 0) return "the start cannot be evaluated";
  function.RefineFromBest();
  ceres::Solver::Options options = CeresOptions(function.size(), MakeTrustRegionOptions());
  options.max_num_iterations = rounds;
  return Solve(function, options, best);
}

std::string RunDogleg(BudgetedFunction& function, bool subspace) {
  Eigen::VectorXd residual;
  if (!function.Evaluate(Eigen::VectorXd::Zero(function.size()), &residual, nullptr))
    return "the start cannot be evaluated";
  ceres::Solver::Options options = CeresOptions(function.size(), MakeTrustRegionOptions());
  options.trust_region_strategy_type = ceres::DOGLEG;
  options.dogleg_type = subspace ? ceres::SUBSPACE_DOGLEG : ceres::TRADITIONAL_DOGLEG;
  // The radius is in units of the columns' norms: it has the size of the predicted change of r.
  options.initial_trust_region_radius = residual.norm();
  return Solve(function, options, Eigen::VectorXd::Zero(function.size()));
}

std::string RunLbfgs(BudgetedFunction& function) {
  StopWhenSpent stop(function);
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::LBFGS;
  options.max_num_iterations = MakeTrustRegionOptions().max_iterations;
  options.function_tolerance = kLastCostTolerance;
  options.gradient_tolerance = options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  options.callbacks.push_back(&stop);
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(function.size());
  ceres::GradientProblem problem(new BudgetedGradient(function));
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, theta.data(), &summary);
  return summary.message;
}

}  // namespace drape
