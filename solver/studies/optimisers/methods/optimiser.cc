// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/optimiser.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "physics/util/errors.h"
#include "solver/studies/optimisers/methods/optimiser_methods.h"

namespace drape {
namespace {

std::vector<OptimiserMethod> MethodsWithDerivatives() {
  return {{"lm", true, true, "Levenberg–Marquardt (Ceres), the steps of drape_fit"},
          {"lm_patient", true, true, "the same, 50 instead of 5 invalid steps in a row"},
          {"dogleg", true, true, "Powell's dogleg (Ceres)"},
          {"subspace_dogleg", true, true, "subspace dogleg (Ceres)"},
          {"lbfgs", true, true, "L-BFGS with Wolfe line search (Ceres)"},
          {"adam_published", true, true, "Adam, learning rates of the published experiments"},
          {"adam_0.03", true, true, "Adam, rate 0.03 in log units"},
          {"adam_0.1", true, true, "Adam, rate 0.1 in log units"}};
}

std::vector<OptimiserMethod> MethodsWithoutDerivatives() {
  const bool nlopt = NLoptIsThere();
  std::vector<OptimiserMethod> methods = {
      {"bobyqa", false, nlopt, "BOBYQA (NLopt), quadratic models"},
      {"sbplx", false, nlopt, "Subplex (NLopt), Nelder–Mead in subspaces"},
      {"crs", false, nlopt, "controlled random search (NLopt CRS2), in a box", true},
      {"direct", false, nlopt, "DIRECT-L (NLopt), in a box"},
      {"cmaes", false, true, "CMA-ES, in a box", true, false},
      {"bo", false, true, "Bayesian optimisation, in a box", true, false}};
  const auto add = [&](const std::string& name, const std::string& summary) {
    methods.push_back({name, false, true, summary, true, false});
  };
  for (const std::string d : {"2", "4", "8"}) add("rembo_" + d, "REMBO, " + d + " numbers");
  add("rembo_ucb_4", "REMBO, 4 numbers, settings of its first publication");
  for (const std::string d : {"2", "4", "8"}) add("hesbo_" + d, "HeSBO, " + d + " numbers");
  return methods;
}

std::vector<OptimiserMethod> AllMethods() {
  std::vector<OptimiserMethod> methods = MethodsWithDerivatives(), refined;
  for (const OptimiserMethod& method : MethodsWithoutDerivatives()) {
    methods.push_back(method);
    refined.push_back(method);
    refined.back().name += "_lm";
    refined.back().summary +=
        "; then " + std::to_string(kRefiningRounds) + " rounds of Levenberg–Marquardt";
    refined.back().by_default = false;
    refined.back().search = method.name;
  }
  methods.insert(methods.end(), refined.begin(), refined.end());
  return methods;
}

std::string RunWithoutDerivatives(const std::string& name, BudgetedFunction& function,
                                  const OptimiserOptions& options) {
  for (const char* nlopt : {"bobyqa", "sbplx", "crs", "direct"})
    if (name == nlopt) return RunNLopt(function, name, options);
  return RunSearch(function, *MakeSearch(name, function.size(), options));
}

std::string RunRefined(const std::string& search, BudgetedFunction& function,
                       const OptimiserOptions& options) {
  function.LimitTo(std::max(1.0, options.budget - RefiningBudget(options)));
  RunWithoutDerivatives(search, function, options);
  function.LimitTo(options.budget);
  return RefineByLevenbergMarquardt(function, kRefiningRounds);
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
    if (method.name == name && !method.available)
      throw InputError("methods", "'" + name + "' is one of NLopt, which this build is without");
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

}  // namespace drape
