// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "physics/simulation/backend.h"

namespace drape::test {

// EquilibriumJvp from EquilibriumTangents: the sum of the columns.
inline std::vector<Eigen::VectorXd> SumEquilibriumTangents(
    Backend& backend, std::span<const RolloutInput> batch,
    std::span<const MaterialField* const> changes) {
  std::vector<Eigen::VectorXd> directions;
  for (const RowMatrix& tangent : backend.EquilibriumTangents(batch, changes))
    directions.push_back(tangent.rowwise().sum());
  return directions;
}

}  // namespace drape::test
