// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace drape {

struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

// Indices of the points that no other point beats in both, cheapest first; of equal points the
// first. Errors that differ by rounding alone (10⁻⁶ of themselves), as those of one drape by two
// backends do, are equal. Points with a number that is not finite are left out.
std::vector<int> ParetoFront(const std::vector<CostAndError>& points);

}  // namespace drape
