// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <cmath>
#include <map>
#include <nlopt.hpp>
#include <optional>

#include "solver/studies/optimisers/methods/metered_cost.h"
#include "solver/studies/optimisers/methods/optimiser_methods.h"

namespace drape {
namespace {

// The cost as these methods see it: a finite number wherever the start has one.
class FiniteCost {
 public:
  FiniteCost(BudgetedFunction& function, double failed_factor)
      : function_(function), cost_(function), failed_factor_(failed_factor) {}

  double operator()(const std::vector<double>& theta) {
    if (function_.exhausted()) throw nlopt::forced_stop();
    const std::optional<double> cost = cost_.Evaluate(
        Eigen::Map<const Eigen::VectorXd>(theta.data(), static_cast<Eigen::Index>(theta.size())));
    if (cost) return *cost;
    const bool has_start = !function_.run().trace.empty();
    return has_start ? failed_factor_ * function_.run().trace.front().cost : HUGE_VAL;
  }

 private:
  BudgetedFunction& function_;
  MeteredCost cost_;
  double failed_factor_;
};

double Objective(const std::vector<double>& theta, std::vector<double>&, void* cost) {
  return (*static_cast<FiniteCost*>(cost))(theta);
}

nlopt::algorithm FindAlgorithm(const std::string& name) {
  static const std::map<std::string, nlopt::algorithm> algorithms = {
      {"bobyqa", nlopt::LN_BOBYQA},
      {"sbplx", nlopt::LN_SBPLX},
      {"crs", nlopt::GN_CRS2_LM},
      {"direct", nlopt::GN_DIRECT_L}};
  const auto found = algorithms.find(name);
  CHECK(found != algorithms.end()) << name;
  return found->second;
}

}  // namespace

bool NLoptIsThere() { return true; }

std::string RunNLopt(BudgetedFunction& function, const std::string& name,
                     const OptimiserOptions& options) {
  constexpr double kFirstStep = 0.5;  // in log units
  const unsigned size = static_cast<unsigned>(function.size());
  FiniteCost cost(function, options.failed_cost_factor);
  std::vector<double> theta(size, 0.0);
  nlopt::srand(static_cast<unsigned long>(options.seed));
  nlopt::opt optimiser(FindAlgorithm(name), size);
  optimiser.set_min_objective(&Objective, &cost);
  optimiser.set_lower_bounds(-options.bound);
  optimiser.set_upper_bounds(options.bound);
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
