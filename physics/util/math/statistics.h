// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace drape {

// y = factor·x^exponent by least squares of the logarithms.
struct PowerLaw {
  double exponent = 0.0;
  double factor = 0.0;
};
// Empty for fewer than two distinct x. CHECKs that all are positive.
std::optional<PowerLaw> FitPowerLaw(std::span<const double> x, std::span<const double> y);

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
