// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>

#include "physics/cloth/contact/barrier.h"
#include "physics/cloth/contact/obstacle.h"
#include "physics/util/math/vec3.h"

namespace drape {

// Contact of one vertex with obstacles, for host and device [MODEL, M60].

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

// An obstacle that a formula gives, as plain data.
struct Solid {
  enum class Kind : int { kPlane, kSphere, kCapsule, kPlate };
  Kind kind = Kind::kPlane;
  // Plane: its normal. Sphere: its centre. Capsule: one end. Plate: the centre of its upper face.
  Vec3<double> first{0.0, 0.0, 0.0};
  Vec3<double> second{0.0, 0.0, 0.0};  // of a capsule: the other end
  double size = 0.0;                   // of a plane: its offset; of the others: the radius [m]
  double thickness = 0.0, rim_radius = 0.0;  // of a plate [m]
};
// Empty for a mesh of triangles.
std::optional<Solid> MakeSolid(const Obstacle& obstacle);

// ObstacleDistance as plain data.
struct SolidDistance {
  double value = 0.0;
  Vec3<double> normal{0.0, 0.0, 0.0};
  SymmetricMatrix curvature;
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

DRAPE_HD inline SolidDistance DistanceToCapsule(const Solid& capsule, const Vec3<double>& x) {
  const Vec3<double> axis = capsule.second - capsule.first, offset = x - capsule.first,
                     none{0.0, 0.0, 0.0};
  const double square = Dot(axis, axis);
  const double along = square > 0.0 ? Dot(axis, offset) / square : 0.0;
  if (along <= 0.0) return AwayFrom(offset, capsule.size, none);
  if (along >= 1.0) return AwayFrom(x - capsule.second, capsule.size, none);
  return AwayFrom(offset - along * axis, capsule.size, (1.0 / std::sqrt(square)) * axis);
}

// In the half-plane of the axis: the distance from a rectangle with rounded corners.
DRAPE_HD inline SolidDistance DistanceToPlate(const Solid& plate, const Vec3<double>& x) {
  const Vec3<double> offset = x - plate.first;
  const double r = std::hypot(offset.x, offset.y), half = 0.5 * plate.thickness;
  const double z = offset.z + half, side = z < 0.0 ? -1.0 : 1.0;
  Vec3<double> out{1.0, 0.0, 0.0};
  if (r > 0.0) out = {offset.x / r, offset.y / r, 0.0};
  const Vec3<double> up{0.0, 0.0, side}, around = Cross(up, out);
  // From the rectangle that the rim is around.
  const double over_r = r - (plate.size - plate.rim_radius);
  const double over_z = side * z - (half - plate.rim_radius);
  SolidDistance distance;
  double slope_r = 0.0;  // ∂distance/∂r
  if (over_r > 0.0 && over_z > 0.0) {
    const double length = std::hypot(over_r, over_z);
    slope_r = over_r / length;
    const double slope_z = over_z / length;
    distance.value = length - plate.rim_radius;
    distance.normal = slope_r * out + slope_z * up;
    AddSquare(1.0 / length, slope_z * out - slope_r * up, distance.curvature);
  } else if (over_r > over_z) {
    slope_r = 1.0;
    distance.value = over_r - plate.rim_radius;
    distance.normal = out;
  } else {
    distance.value = over_z - plate.rim_radius;
    distance.normal = up;
  }
  if (slope_r > 0.0) AddSquare(slope_r / r, around, distance.curvature);
  return distance;
}

DRAPE_HD inline SolidDistance DistanceTo(const Solid& solid, const Vec3<double>& x) {
  switch (solid.kind) {
    case Solid::Kind::kSphere:
      return AwayFrom(x - solid.first, solid.size, {0.0, 0.0, 0.0});
    case Solid::Kind::kCapsule:
      return DistanceToCapsule(solid, x);
    case Solid::Kind::kPlate:
      return DistanceToPlate(solid, x);
    case Solid::Kind::kPlane:
      break;
  }
  SolidDistance distance;
  distance.value = Dot(solid.first, x) - solid.size;
  distance.normal = solid.first;
  return distance;
}

// Contact with solids, the same data as Contact; the formulas below take this or anything else with
// its members.
struct SolidContact {
  double thickness = 0.0, range = 0.0;  // [m]
  double stiffness = 0.0;               // [Pa]
  int count = 0;                        // of the obstacles
  const Solid* solids = nullptr;

  DRAPE_HD SolidDistance Distance(int k, const Vec3<double>& x) const {
    return DistanceTo(solids[k], x);
  }
  DRAPE_HD bool IsConvex(int) const { return true; }
};

// Calls of(barrier, distance) for each obstacle within range of x.
template <class Contact, class Of>
DRAPE_HD void ForEachNear(const Contact& contact, const Vec3<double>& x, const Of& of) {
  for (int k = 0; k < contact.count; ++k) {
    const SolidDistance distance = contact.Distance(k, x);
    const double gap = distance.value - 0.5 * contact.thickness;
    if (gap < contact.range) of(EvaluateBarrier(gap, contact.range), distance);
  }
}

// Of one vertex at x that stands for `area` of the cloth [m²]: the energy [J], the force f [N],
// scale times the positive semidefinite part H of −∂f/∂x [N/m], and ∂g/∂x of g(x; w) = h·f(x) −
// h²·H(x)·w with w held [MODEL, M31], which is not symmetric.
template <class Contact>
DRAPE_HD double VertexEnergy(const Contact& contact, double area, const Vec3<double>& x) {
  double energy = 0.0;
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance&) {
    energy += contact.stiffness * area * b.value;
  });
  return energy;
}
template <class Contact>
DRAPE_HD Vec3<double> VertexForce(const Contact& contact, double area, const Vec3<double>& x) {
  Vec3<double> force{0.0, 0.0, 0.0};
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance& d) {
    force = force - (contact.stiffness * area * b.slope) * d.normal;
  });
  return force;
}
template <class Contact>
DRAPE_HD void AddVertexStepStiffness(const Contact& contact, double area, const Vec3<double>& x,
                                     double scale, double (&block)[9]) {
  const double k = scale * contact.stiffness * area;
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance& d) {
    AddToBlock(k * b.curvature, d.normal, d.normal, block);
    // b' < 0. A convex solid has the other sign; that of a blend is the same in all directions.
    if (Trace(d.curvature) < 0.0) AddToBlock(k * b.slope, d.curvature, block);
  });
}
template <class Contact>
DRAPE_HD void AddVertexStepDerivative(const Contact& contact, double area, const Vec3<double>& x,
                                      const Vec3<double>& w, double h, double (&block)[9]) {
  const double k = -contact.stiffness * area * h;
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance& d) {
    const double speed = Dot(d.normal, w);
    AddToBlock(k * (b.curvature + h * b.third * speed), d.normal, d.normal, block);
    AddToBlock(k * (b.slope + h * b.curvature * speed), d.curvature, block);
    AddToBlock(k * h * b.curvature, d.normal, d.curvature * w, block);
  });
}

// Moves x away from obstacles where the gap is less than a tenth of the range; returns whether it
// has.
template <class Contact>
DRAPE_HD bool PushVertexOut(const Contact& contact, Vec3<double>& x) {
  constexpr double kLeast = 0.1, kNew = 0.5;  // gaps, of the range
  constexpr int kRounds = 10;                 // out of one obstacle can be into another
  bool moved = false;
  for (int round = 0, pushes = 1; round < kRounds && pushes > 0; ++round) {
    pushes = 0;
    for (int k = 0; k < contact.count; ++k) {
      const SolidDistance distance = contact.Distance(k, x);
      const double gap = distance.value - 0.5 * contact.thickness;
      if (gap >= kLeast * contact.range) continue;
      x = x + (kNew * contact.range - gap) * distance.normal;
      ++pushes;
      moved = true;
    }
  }
  return moved;
}

// The share of the move dx from x that leaves a tenth of the gap from obstacle k. The distance from
// a convex solid is convex along a line, so its tangent is a lower bound, and Newton's method comes
// from the safe side. From any other it changes by no more than x does.
template <class Contact>
DRAPE_HD double SafeShareFrom(const Contact& contact, int k, const Vec3<double>& x,
                              const Vec3<double>& dx) {
  constexpr double kKept = 0.1, kEnough = 0.02;  // of the first gap
  constexpr int kMostSteps = 50;
  const bool is_convex = contact.IsConvex(k);
  double share = 0.0, kept = 0.0, enough = 0.0;
  for (int i = 0; i < kMostSteps; ++i) {
    const SolidDistance distance = contact.Distance(k, x + share * dx);
    const double gap = distance.value - 0.5 * contact.thickness;
    if (i == 0) {
      kept = kKept * gap;
      enough = (kKept + kEnough) * gap;
    }
    const double approach = is_convex ? -Dot(distance.normal, dx) : std::sqrt(Dot(dx, dx));
    if (approach <= 0.0) return 1.0;
    if (gap <= enough) break;
    share += (gap - kept) / approach;
    if (share >= 1.0) return 1.0;
  }
  return share;
}
// From all of them.
template <class Contact>
DRAPE_HD double SafeShare(const Contact& contact, const Vec3<double>& x, const Vec3<double>& dx) {
  double share = 1.0;
  for (int k = 0; k < contact.count; ++k)
    share = std::fmin(share, SafeShareFrom(contact, k, x, dx));
  return share;
}

}  // namespace drape
