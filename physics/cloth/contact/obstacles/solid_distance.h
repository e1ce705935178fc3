// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/util/math/vec3.h"

namespace drape {

// Distances from points and segments, for host and device.

struct SymmetricMatrix {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
};
DRAPE_INLINE double Trace(const SymmetricMatrix& m) { return m.xx + m.yy + m.zz; }
DRAPE_INLINE Vec3<double> operator*(const SymmetricMatrix& m, const Vec3<double>& a) {
  return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
          m.xz * a.x + m.yz * a.y + m.zz * a.z};
}
// m += s·a·aᵀ.
DRAPE_INLINE void AddSquare(double s, const Vec3<double>& a, SymmetricMatrix& m) {
  m.xx += s * a.x * a.x;
  m.xy += s * a.x * a.y;
  m.xz += s * a.x * a.z;
  m.yy += s * a.y * a.y;
  m.yz += s * a.y * a.z;
  m.zz += s * a.z * a.z;
}
DRAPE_INLINE void AddScaled(double s, const SymmetricMatrix& a, SymmetricMatrix& m) {
  m.xx += s * a.xx;
  m.xy += s * a.xy;
  m.xz += s * a.xz;
  m.yy += s * a.yy;
  m.yz += s * a.yz;
  m.zz += s * a.zz;
}
// block += s·m; s·a·bᵀ. Blocks are of 3 × 3, row by row.
DRAPE_INLINE void AddToBlock(double s, const SymmetricMatrix& m, double (&block)[9]) {
  const double rows[9] = {m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz};
  for (int n = 0; n < 9; ++n) block[n] += s * rows[n];
}
DRAPE_INLINE void AddToBlock(double s, const Vec3<double>& a, const Vec3<double>& b,
                             double (&block)[9]) {
  const double rows[3] = {s * a.x, s * a.y, s * a.z}, columns[3] = {b.x, b.y, b.z};
  for (int n = 0; n < 9; ++n) block[n] += rows[n / 3] * columns[n % 3];
}

// Whether m is negative semidefinite to rounding, and not 0.
DRAPE_HD inline bool IsNegativeSemidefinite(const SymmetricMatrix& m) {
  constexpr double kRounding = 1e-10;
  const double size = -Trace(m), more = kRounding * size;
  if (!(size > 0.0)) return false;
  const double first = more - m.xx;
  if (!(first > 0.0)) return false;
  const double second = more - m.yy - m.xy * m.xy / first, mixed = -m.yz - m.xy * m.xz / first;
  if (!(second > 0.0)) return false;
  return more - m.zz - m.xz * m.xz / first - mixed * mixed / second > 0.0;
}

// ObstacleDistance as plain data.
struct SolidDistance {
  double value = 0.0;
  Vec3<double> normal{0.0, 0.0, 0.0};
  SymmetricMatrix curvature;
  SymmetricMatrix blend = {};  // the negative semidefinite part of it that H has [MODEL, M60]
};

// From a point, less a radius. `fixed`: a direction of unit length in which that point follows x,
// or zero.
DRAPE_HD inline SolidDistance AwayFrom(const Vec3<double>& offset, double radius,
                                       const Vec3<double>& fixed) {
  const double length = std::sqrt(Dot(offset, offset));
  SolidDistance distance;
  distance.value = length - radius;
  distance.normal = {0.0, 0.0, 1.0};
  if (!(length > 0.0)) return distance;
  distance.normal = (1.0 / length) * offset;
  distance.curvature.xx = distance.curvature.yy = distance.curvature.zz = 1.0 / length;
  AddSquare(-1.0 / length, fixed, distance.curvature);
  AddSquare(-1.0 / length, distance.normal, distance.curvature);
  return distance;
}

// From the points within `radius` of a segment.
DRAPE_HD inline SolidDistance DistanceToSegment(const Vec3<double>& from, const Vec3<double>& to,
                                                double radius, const Vec3<double>& x) {
  const Vec3<double> axis = to - from, offset = x - from, none{0.0, 0.0, 0.0};
  const double square = Dot(axis, axis);
  const double along = square > 0.0 ? Dot(axis, offset) / square : 0.0;
  if (along <= 0.0) return AwayFrom(offset, radius, none);
  if (along >= 1.0) return AwayFrom(x - to, radius, none);
  return AwayFrom(offset - along * axis, radius, (1.0 / std::sqrt(square)) * axis);
}

}  // namespace drape
