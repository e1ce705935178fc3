// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace drape {

// A logistic map of the real line onto the numbers between two bounds.
struct BoundedNumber {
  double low, high;

  double At(double u) const { return low + (high - low) * Share(u); }
  // The u of a value, which is taken as no nearer to a bound than this share of the range.
  double From(double value, double least_share) const {
    const double share = std::clamp((value - low) / (high - low), least_share, 1.0 - least_share);
    return std::log(share / (1.0 - share));
  }
  // dAt/du.
  double Slope(double u) const { return (high - low) * Share(u) * (1.0 - Share(u)); }

 private:
  static double Share(double u) { return 1.0 / (1.0 + std::exp(-u)); }
};

}  // namespace drape
