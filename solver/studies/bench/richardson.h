// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace drape {

// As [Richardson 1911]: of a quantity q(s) = q(0) + c·s^order of the size s of the elements
// or steps, the limit q(0) from the values at s_fine and s_coarse = ratio·s_fine, ratio > 1.
// Scalars or Eigen's arrays of them. The error of q(s_fine) is estimated as its difference from the
// limit, and taken for the limit's own.
template <class Quantity>
Quantity Extrapolate(const Quantity& fine, const Quantity& coarse, double ratio, double order) {
  return fine + (fine - coarse) / (std::pow(ratio, order) - 1.0);
}

}  // namespace drape
