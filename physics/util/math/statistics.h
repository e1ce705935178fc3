// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

namespace drape {

// The value at rank share·(n − 1), 0 ≤ share ≤ 1, of n ≥ 1 ascending values, linear between
// neighbours; the values may be infinite.
inline double Quantile(const std::vector<double>& sorted, double share) {
  const double rank = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const double part = rank - static_cast<double>(below);
  // Equal neighbours may be infinite, and their difference none.
  return part > 0.0 && sorted[below + 1] > sorted[below]
             ? sorted[below] + part * (sorted[below + 1] - sorted[below])
             : sorted[below];
}

}  // namespace drape
