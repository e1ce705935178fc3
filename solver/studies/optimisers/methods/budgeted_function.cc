// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/budgeted_function.h"

#include <glog/logging.h>

#include <ctime>

namespace drape {
namespace {

double ThreadSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

void OptimiserOptions::Check() const {
  CHECK_GT(budget, 0.0) << "OptimiserOptions::budget";
  CHECK_GE(jacobian_cost_units, 0.0) << "OptimiserOptions::jacobian_cost_units";
  CHECK_GT(bound, 0.0) << "OptimiserOptions::bound";
  CHECK_GT(failed_cost_factor, 1.0) << "OptimiserOptions::failed_cost_factor";
}

BudgetedFunction::BudgetedFunction(ResidualFunction& function, const OptimiserOptions& options)
    : function_(function), options_(options), start_(ThreadSeconds()) {
  options.Check();
}

bool BudgetedFunction::exhausted() const {
  constexpr double kMostCalls = 10.0;
  return run_.spent >= options_.budget || run_.evaluations >= kMostCalls * options_.budget ||
         (options_.cancel != nullptr && options_.cancel->load());
}

bool BudgetedFunction::Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                                RowMatrix* jacobian) {
  const bool here = theta_.size() == theta.size() && theta_ == theta;
  if (!here && !EvaluateResidual(theta)) return false;
  if (!valid_) return false;
  if (jacobian != nullptr && jacobian_.size() == 0 && !EvaluateJacobian()) return false;
  *residual = residual_;
  if (jacobian != nullptr) *jacobian = jacobian_;
  return true;
}

bool BudgetedFunction::EvaluateResidual(const Eigen::VectorXd& theta) {
  if (exhausted()) return false;
  theta_ = theta;
  jacobian_.resize(0, 0);
  valid_ = function_.Evaluate(theta, &residual_, nullptr);
  run_.spent += function_.cost_units();
  ++run_.evaluations;
  run_.seconds = ThreadSeconds() - start_;
  if (valid_) {
    Record(0.5 * residual_.squaredNorm());
  } else {
    ++run_.failed;
  }
  return valid_;
}

bool BudgetedFunction::EvaluateJacobian() {
  if (exhausted()) return false;
  const bool found = function_.Evaluate(theta_, &residual_, &jacobian_);
  if (!found) {
    jacobian_.resize(0, 0);
    ++run_.failed;
  }
  run_.spent += options_.jacobian_cost_units;
  ++run_.jacobians;
  run_.jacobian_seconds += ThreadSeconds() - start_ - run_.seconds;
  run_.seconds = ThreadSeconds() - start_;
  return found;
}

void BudgetedFunction::Record(double cost) {
  if (!(cost < run_.cost)) return;
  run_.cost = cost;
  run_.theta = theta_;
  run_.trace.push_back({run_.spent, run_.seconds, cost});
}

}  // namespace drape
