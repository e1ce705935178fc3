// SPDX-License-Identifier: Apache-2.0
#include <ceres/ceres.h>

#include <algorithm>

#include "solver/fit.h"
#include "solver/optimiser_methods.h"
#include "solver/staged_fit.h"

namespace drape {
namespace {

Eigen::VectorXd VectorOf(const double* values, int size) {
  return Eigen::Map<const Eigen::VectorXd>(values, size);
}

class MeteredCost final : public ceres::CostFunction {
 public:
  explicit MeteredCost(MeteredFunction& function) : function_(function) {
    set_num_residuals(function.num_residuals());
    mutable_parameter_block_sizes()->push_back(function.size());
  }
  bool Evaluate(double const* const* theta, double* residuals, double** jacobians) const override {
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    if (!function_.Evaluate(VectorOf(theta[0], function_.size()), &residual,
                            with_jacobian ? &jacobian : nullptr))
      return false;
    std::copy_n(residual.data(), residual.size(), residuals);
    if (with_jacobian) std::copy_n(jacobian.data(), jacobian.size(), jacobians[0]);
    return true;
  }

 private:
  MeteredFunction& function_;
};

class MeteredGradient final : public ceres::FirstOrderFunction {
 public:
  explicit MeteredGradient(MeteredFunction& function) : function_(function) {}
  int NumParameters() const override { return function_.size(); }
  bool Evaluate(const double* theta, double* cost, double* gradient) const override {
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    if (!function_.Evaluate(VectorOf(theta, function_.size()), &residual,
                            gradient != nullptr ? &jacobian : nullptr))
      return false;
    *cost = 0.5 * residual.squaredNorm();
    if (gradient != nullptr)
      Eigen::Map<Eigen::VectorXd>(gradient, function_.size()) = jacobian.transpose() * residual;
    return true;
  }

 private:
  MeteredFunction& function_;
};

class StopWhenSpent final : public ceres::IterationCallback {
 public:
  explicit StopWhenSpent(const MeteredFunction& function) : function_(function) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return function_.exhausted() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const MeteredFunction& function_;
};

// As the last round of a fit.
FitOptions FitOptionsOf() {
  FitOptions options;
  options.initial_damping = StagedFitOptions().initial_damping;
  options.max_iterations = 1000000;
  options.cost_tolerance = kLastCostTolerance;
  return options;
}

std::string Solve(MeteredFunction& function, ceres::Solver::Options options) {
  StopWhenSpent stop(function);
  options.callbacks.push_back(&stop);
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(function.size());
  ceres::Problem problem;
  problem.AddResidualBlock(new MeteredCost(function), nullptr, theta.data());
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.message;
}

}  // namespace

std::string RunLevenbergMarquardt(MeteredFunction& function, int invalid_steps) {
  ceres::Solver::Options options = TrustRegionOptions(function.size(), FitOptionsOf());
  options.max_num_consecutive_invalid_steps = invalid_steps;
  return Solve(function, options);
}

std::string RunDogleg(MeteredFunction& function, bool subspace) {
  Eigen::VectorXd residual;
  if (!function.Evaluate(Eigen::VectorXd::Zero(function.size()), &residual, nullptr))
    return "the start cannot be evaluated";
  ceres::Solver::Options options = TrustRegionOptions(function.size(), FitOptionsOf());
  options.trust_region_strategy_type = ceres::DOGLEG;
  options.dogleg_type = subspace ? ceres::SUBSPACE_DOGLEG : ceres::TRADITIONAL_DOGLEG;
  // Of a step in units of the columns' norms, so of the size of the change of r that it predicts.
  options.initial_trust_region_radius = residual.norm();
  return Solve(function, options);
}

std::string RunLbfgs(MeteredFunction& function) {
  StopWhenSpent stop(function);
  ceres::GradientProblemSolver::Options options;
  options.line_search_direction_type = ceres::LBFGS;
  options.max_num_iterations = FitOptionsOf().max_iterations;
  options.function_tolerance = kLastCostTolerance;
  options.gradient_tolerance = options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  options.callbacks.push_back(&stop);
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(function.size());
  ceres::GradientProblem problem(new MeteredGradient(function));
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(options, problem, theta.data(), &summary);
  return summary.message;
}

}  // namespace drape
