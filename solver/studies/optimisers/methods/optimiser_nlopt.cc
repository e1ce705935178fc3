// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlopt.hpp>

#include "solver/studies/optimisers/methods/optimiser_methods.h"

namespace drape {
namespace {

// The cost as these methods see it: a finite number everywhere.
class FiniteCost {
 public:
  FiniteCost(BudgetedFunction& function, double failed_factor)
      : function_(function), failed_factor_(failed_factor) {}

  double operator()(const std::vector<double>& theta) {
    if (function_.exhausted()) throw nlopt::forced_stop();
    const Eigen::VectorXd here =
        Eigen::Map<const Eigen::VectorXd>(theta.data(), static_cast<Eigen::Index>(theta.size()));
    Eigen::VectorXd residual;
    if (!function_.Evaluate(here, &residual, nullptr)) {
      const bool has_start = !function_.run().trace.empty();
      return has_start ? failed_factor_ * function_.run().trace.front().cost : HUGE_VAL;
    }
    const double cost = 0.5 * residual.squaredNorm();
    Follow(here, cost);
    return cost;
  }

 private:
  // A function that starts from the last point with derivatives (DrapeFunction) does not find its
  // way when that stays behind: once the cost is lower by a tenth, they are requested and counted.
  void Follow(const Eigen::VectorXd& here, double cost) {
    constexpr double kGain = 0.9;
    if (!(cost < kGain * followed_)) return;
    followed_ = cost;
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    function_.Evaluate(here, &residual, &jacobian);
  }

  BudgetedFunction& function_;
  double failed_factor_;
  double followed_ = std::numeric_limits<double>::infinity();
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
