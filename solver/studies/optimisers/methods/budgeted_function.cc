// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/budgeted_function.h"

#include <glog/logging.h>

#include <algorithm>
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
}

BudgetedFunction::BudgetedFunction(ResidualFunction& function, const OptimiserOptions& options)
    : function_(function), options_(options), start_(ThreadSeconds()), limit_(options.budget) {
  options.Check();
}

bool BudgetedFunction::exhausted() const {
  constexpr double kMostCalls = 10.0;
  return run_.spent >= std::min(limit_, options_.budget) ||
         run_.evaluations >= kMostCalls * options_.budget ||
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

void BudgetedFunction::RefineFromBest() {
  theta_.resize(0);
  function_.RefineFromBest();
}

bool BudgetedFunction::Call(RowMatrix* jacobian) {
  const double begin = ThreadSeconds();
  const bool found = function_.Evaluate(theta_, &residual_, jacobian);
  const double end = ThreadSeconds();
  run_.function_seconds += end - begin;
  if (jacobian != nullptr) run_.jacobian_seconds += end - begin;
  run_.seconds = end - start_;
  return found;
}

bool BudgetedFunction::EvaluateResidual(const Eigen::VectorXd& theta) {
  if (exhausted()) return false;
  theta_ = theta;
  jacobian_.resize(0, 0);
  valid_ = Call(nullptr);
  run_.spent += function_.cost_units();
  ++run_.evaluations;
  if (valid_) {
    Record(0.5 * residual_.squaredNorm());
  } else {
    ++run_.failed;
  }
  return valid_;
}

bool BudgetedFunction::EvaluateJacobian() {
  if (exhausted()) return false;
  const bool found = Call(&jacobian_);
  if (!found) {
    jacobian_.resize(0, 0);
    ++run_.failed;
  }
  run_.spent += options_.jacobian_cost_units;
  ++run_.jacobians;
  return found;
}

void BudgetedFunction::Record(double cost) {
  if (!(cost < run_.cost)) return;
  run_.cost = cost;
  run_.theta = theta_;
  run_.trace.push_back({run_.spent, run_.seconds, cost});
}

std::optional<double> MeteredCost::Evaluate(const Eigen::VectorXd& theta) {
  constexpr double kGain = 0.9;
  Eigen::VectorXd residual;
  if (!function_.Evaluate(theta, &residual, nullptr)) return std::nullopt;
  const double cost = 0.5 * residual.squaredNorm();
  if (!(cost < kGain * followed_)) return cost;
  followed_ = cost;
  RowMatrix jacobian;
  function_.Evaluate(theta, &residual, &jacobian);
  return cost;
}

}  // namespace drape
