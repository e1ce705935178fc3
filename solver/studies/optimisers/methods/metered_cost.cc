// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/metered_cost.h"

namespace drape {

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
