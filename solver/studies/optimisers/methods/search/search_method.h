// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace drape {

// A search without derivatives: it proposes points, its caller reports their costs. Knows nothing
// of budgets. A search depends on its seed and the reported costs alone.
class SearchMethod {
 public:
  virtual ~SearchMethod() = default;
  // The next point, shape [P]; the first is 0.
  virtual Eigen::VectorXd Propose() = 0;
  // The cost at the point proposed last, ≥ 0; none where the function cannot be evaluated.
  virtual void Report(std::optional<double> cost) = 0;
  // Further points would differ by less than rounding lets the search tell.
  virtual bool converged() const { return false; }
};

}  // namespace drape
