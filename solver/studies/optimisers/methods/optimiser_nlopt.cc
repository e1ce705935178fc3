// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <cmath>
#include <nlopt.hpp>
#include <optional>

#include "solver/studies/optimisers/methods/optimiser.h"

namespace drape {
namespace {

// The cost as these methods see it: a finite number wherever the start has one.
class FiniteCost {
 public:
  explicit FiniteCost(BudgetedFunction& function) : function_(function), cost_(function) {}

  double operator()(const std::vector<double>& theta) {
    constexpr double kFailed = 10.0;  // times the cost of the start
    if (function_.exhausted()) throw nlopt::forced_stop();
    const std::optional<double> cost = cost_.Evaluate(
        Eigen::Map<const Eigen::VectorXd>(theta.data(), static_cast<Eigen::Index>(theta.size())));
    if (cost) return *cost;
    const bool has_start = !function_.run().trace.empty();
    return has_start ? kFailed * function_.run().trace.front().cost : HUGE_VAL;
  }

 private:
  BudgetedFunction& function_;
  MeteredCost cost_;
};

double Objective(const std::vector<double>& theta, std::vector<double>&, void* cost) {
  return (*static_cast<FiniteCost*>(cost))(theta);
}

nlopt::algorithm FindAlgorithm(const std::string& name) {
  if (name == "bobyqa") return nlopt::LN_BOBYQA;
  if (name == "sbplx") return nlopt::LN_SBPLX;
  if (name == "crs") return nlopt::GN_CRS2_LM;
  CHECK_EQ(name, "direct");
  return nlopt::GN_DIRECT_L;
}

}  // namespace

std::string RunNLopt(BudgetedFunction& function, const std::string& name, int seed) {
  constexpr double kFirstStep = 0.5;  // in log units
  const unsigned size = static_cast<unsigned>(function.size());
  FiniteCost cost(function);
  std::vector<double> theta(size, 0.0);
  nlopt::srand(static_cast<unsigned long>(seed));
  nlopt::opt optimiser(FindAlgorithm(name), size);
  optimiser.set_min_objective(&Objective, &cost);
  optimiser.set_lower_bounds(-kBound);
  optimiser.set_upper_bounds(kBound);
  optimiser.set_initial_step(kFirstStep);
  optimiser.set_xtol_abs(1e-6);
  double least = 0.0;
  try {
    cost(theta);  // not all of them begin with the start
    optimiser.optimize(theta, least);
  } catch (const nlopt::forced_stop&) {
    return "budget spent";
  } catch (const std::runtime_error& error) {  // also of nlopt::roundoff_limited
    return error.what();
  }
  return "converged";
}

}  // namespace drape
