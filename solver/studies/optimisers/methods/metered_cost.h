// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>

#include "solver/studies/optimisers/methods/budgeted_function.h"

namespace drape {

// ½‖r‖² for methods without derivatives. A function that starts from the last point with
// derivatives (DrapeFunction) does not find its way when that stays behind: once the cost is lower
// by a tenth, derivatives are requested and counted.
class MeteredCost {
 public:
  // The function outlives the object.
  explicit MeteredCost(BudgetedFunction& function) : function_(function) {}

  // None where the function cannot be evaluated, or nothing is left to spend.
  std::optional<double> Evaluate(const Eigen::VectorXd& theta);

 private:
  BudgetedFunction& function_;
  double followed_ = std::numeric_limits<double>::infinity();
};

}  // namespace drape
