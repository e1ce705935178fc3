// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/util/math/host_device.h"

namespace drape {

// The barrier of contact, a function of the gap g between two surfaces [MODEL, M60], [Li 2020]:
// b = −r·(y − 1)²·ln y with y = g/r for 0 < g < r, and 0 beyond the range r. Times a stiffness in
// Pa it is an energy by area; −b' is the pressure by stiffness.
struct Barrier {
  double value = 0.0;      // b [m]
  double slope = 0.0;      // b'
  double curvature = 0.0;  // b'' [1/m]
  double third = 0.0;      // b''' [1/m²]
};

// range: r > 0 [m]. Infinite where the gap is not positive.
DRAPE_HD inline Barrier EvaluateBarrier(double gap, double range) {
  constexpr double kInfinite = INFINITY;
  if (gap >= range) return {};
  if (!(gap > 0.0)) return {kInfinite, -kInfinite, kInfinite, -kInfinite};
  const double y = gap / range, below = 1.0 - y, log = std::log(y), ratio = below / y;
  return {-range * below * below * log, 2.0 * below * log - below * ratio,
          (ratio * ratio + 4.0 * ratio - 2.0 * log) / range,
          -(2.0 / y + (4.0 + 2.0 * ratio) / (y * y)) / (range * range)};
}

}  // namespace drape
