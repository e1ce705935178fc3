// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/optimiser.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr const char* kNLopt[] = {"bobyqa", "sbplx", "crs", "direct"};

std::vector<OptimiserMethod> AllMethods() {
  std::vector<OptimiserMethod> methods;
  for (const char* name : {"lm", "lm_patient", "dogleg", "subspace_dogleg", "lbfgs",
                           "adam_published", "adam_0.03", "adam_0.1"})
    methods.push_back({name, true});
  const std::size_t first = methods.size();
  for (const std::string name : kNLopt) methods.push_back({name, false, name == "crs"});
  for (const char* name : {"cmaes", "bo", "rembo_2", "rembo_4", "rembo_8", "rembo_ucb_4", "hesbo_2",
                           "hesbo_4", "hesbo_8"})
    methods.push_back({name, false, true, false});
  const std::size_t end = methods.size();
  for (std::size_t i = first; i < end; ++i)
    methods.push_back({methods[i].name + "_lm", false, methods[i].random, false, methods[i].name});
  return methods;
}

std::string RunWithoutDerivatives(const std::string& name, BudgetedFunction& function,
                                  const OptimiserOptions& options) {
  if (std::find(std::begin(kNLopt), std::end(kNLopt), name) != std::end(kNLopt))
    return RunNLopt(function, name, options.seed);
  return RunSearch(function, name, options);
}

std::string RunRefined(const std::string& search, BudgetedFunction& function,
                       const OptimiserOptions& options) {
  function.LimitTo(std::max(1.0, options.budget - RefiningBudget(options)));
  RunWithoutDerivatives(search, function, options);
  function.LimitTo(options.budget);
  return RefineByLevenbergMarquardt(function, kRefiningRounds);
}

// [Kingma 2015], with its β. rates: [P]. Adam has no rule for a point that cannot be evaluated: it
// goes back to the best one, with half the rates and its moments forgotten.
std::string RunAdam(BudgetedFunction& function, Eigen::VectorXd rates) {
  constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;
  Eigen::VectorXd theta = Eigen::VectorXd::Zero(function.size()), residual, mean, square;
  RowMatrix jacobian;
  for (int step = 0; !function.exhausted();) {
    if (!function.Evaluate(theta, &residual, &jacobian)) {
      if (function.run().theta.size() == 0) return "the start cannot be evaluated";
      const bool best_has_none = theta == function.run().theta;  // no derivatives at the best point
      if (best_has_none) return "no derivatives at the best point";
      theta = function.run().theta;
      rates *= 0.5;
      step = 0;
      continue;
    }
    if (step == 0) mean = square = Eigen::VectorXd::Zero(function.size());
    ++step;
    const Eigen::VectorXd gradient = jacobian.transpose() * residual;
    mean = kBeta1 * mean + (1.0 - kBeta1) * gradient;
    square = kBeta2 * square + (1.0 - kBeta2) * gradient.cwiseAbs2();
    const Eigen::ArrayXd unbiased = mean.array() / (1.0 - std::pow(kBeta1, step));
    const Eigen::ArrayXd size = (square.array() / (1.0 - std::pow(kBeta2, step))).sqrt();
    theta.array() -= rates.array() * unbiased / (size + kEpsilon);
  }
  return "budget spent";
}

std::string Run(const OptimiserMethod& method, BudgetedFunction& function,
                const OptimiserOptions& options) {
  const std::string& name = method.name;
  if (!method.search.empty()) return RunRefined(method.search, function, options);
  if (!method.derivatives) return RunWithoutDerivatives(name, function, options);
  constexpr int kInvalidSteps = 5, kPatientInvalidSteps = 50;
  const auto rates = [&](double rate) { return Eigen::VectorXd::Constant(function.size(), rate); };
  if (name == "lm") return RunLevenbergMarquardt(function, kInvalidSteps);
  if (name == "lm_patient") return RunLevenbergMarquardt(function, kPatientInvalidSteps);
  if (name == "dogleg") return RunDogleg(function, false);
  if (name == "subspace_dogleg") return RunDogleg(function, true);
  if (name == "lbfgs") return RunLbfgs(function);
  if (name == "adam_0.03") return RunAdam(function, rates(0.03));
  if (name == "adam_0.1") return RunAdam(function, rates(0.1));
  CHECK_EQ(name, "adam_published");
  CHECK_EQ(options.published_rates.size(), function.size());
  return RunAdam(function, options.published_rates);
}

}  // namespace

double RefiningBudget(const OptimiserOptions& options) {
  return (kRefiningRounds + 1) * (1.0 + options.jacobian_cost_units);
}

const std::vector<OptimiserMethod>& OptimiserMethods() {
  static const std::vector<OptimiserMethod> methods = AllMethods();
  return methods;
}

const OptimiserMethod& FindOptimiser(const std::string& name) {
  std::string names;
  for (const OptimiserMethod& method : OptimiserMethods()) {
    if (method.name == name) return method;
    names += (names.empty() ? "" : ", ") + method.name;
  }
  throw InputError("methods", "unknown name '" + name + "', expected some of " + names);
}

OptimiserRun RunOptimiser(const std::string& name, ResidualFunction& function,
                          const OptimiserOptions& options) {
  const OptimiserMethod& method = FindOptimiser(name);
  BudgetedFunction metered(function, options);
  const std::string end = Run(method, metered, options);
  OptimiserRun run = metered.run();
  run.method = name;
  run.end = metered.exhausted() ? "budget spent" : end;
  run.cancelled = options.cancel != nullptr && options.cancel->load();
  return run;
}

}  // namespace drape
