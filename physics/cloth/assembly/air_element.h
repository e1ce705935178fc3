// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/util/math/host_device.h"

namespace drape {

// Air at one corner of a face, which has a third of its rest area [MODEL, M65]. n: unit normal of
// the face at the start of the step; v and w: velocity of the corner before and after it; wind
// [m/s]. `drag` is h·c·A/3 [kg·s/m].

// Speed below which the drag grows in proportion to it: it stays differentiable in still air [m/s].
inline constexpr double kAirCreep = 0.01;

template <class T>
DRAPE_HD Vec3<T> UnitNormal(const Vec3<T> (&corner)[3]) {
  using std::sqrt;
  const Vec3<T> N = Cross(corner[1] - corner[0], corner[2] - corner[0]);
  return (1.0 / sqrt(Dot(N, N))) * N;
}

// The coefficient d of the step matrix d·n·nᵀ [kg].
template <class T>
DRAPE_HD T AirCoefficient(const T& drag, const Vec3<T>& n, const Vec3<T>& v, const Vec3<T>& wind) {
  using std::sqrt;
  const T s = Dot(n, v - wind);
  return drag * sqrt(s * s + kAirCreep * kAirCreep);
}

// h·f = −d·n·(n·(w − wind)) [N·s].
template <class T>
DRAPE_HD Vec3<T> AirImpulse(const T& drag, const Vec3<T>& n, const Vec3<T>& v, const Vec3<T>& w,
                            const Vec3<T>& wind) {
  return (-AirCoefficient(drag, n, v, wind) * Dot(n, w - wind)) * n;
}

}  // namespace drape
