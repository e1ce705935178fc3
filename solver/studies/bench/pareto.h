// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace drape {

struct CostAndError {
  double cost = 0.0;
  double error = 0.0;
};

// Indices of the points that no other point beats in both, cheapest first; of equal points the
// first. Points with a number that is not finite are left out.
std::vector<int> ParetoFront(const std::vector<CostAndError>& points);

}  // namespace drape
