// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/cloth/contact/obstacles/obstacle.h"
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

// Contact of one vertex with obstacles, for host and device [MODEL, M60].

// Contact with solids, the same data as Contact; the formulas below take this or anything else with
// its members.
struct SolidContact {
  double thickness = 0.0, range = 0.0;  // [m]
  double stiffness = 0.0;               // [Pa]
  int count = 0;                        // of the obstacles
  const Solid* solids = nullptr;
  bool has_meshes = false;

  DRAPE_HD SolidDistance Distance(int k, const Vec3<double>& x) const {
    return DistanceTo(solids[k], x);
  }
  DRAPE_HD bool IsConvex(int k) const { return drape::IsConvex(solids[k]); }
  DRAPE_HD void AddBlendChange(int k, const Vec3<double>& x, const Vec3<double>& w, double scale,
                               double (&block)[9]) const {
    drape::AddBlendChange(solids[k].surface, x, w, scale, block);
  }
};
// Contact where no obstacle is a mesh: kernels then take half as many registers.
struct FormulaContact : SolidContact {
  DRAPE_HD explicit FormulaContact(const SolidContact& contact) : SolidContact(contact) {}
  DRAPE_HD SolidDistance Distance(int k, const Vec3<double>& x) const {
    return DistanceToFormula(solids[k], x);
  }
  DRAPE_HD bool IsConvex(int) const { return true; }
  DRAPE_HD void AddBlendChange(int, const Vec3<double>&, const Vec3<double>&, double,
                               double (&)[9]) const {}
};

// Calls of(barrier, distance, obstacle) for each obstacle within range of x.
template <class Contact, class Of>
DRAPE_HD void ForEachNear(const Contact& contact, const Vec3<double>& x, const Of& of) {
  for (int k = 0; k < contact.count; ++k) {
    const SolidDistance distance = contact.Distance(k, x);
    const double gap = distance.value - 0.5 * contact.thickness;
    if (gap < contact.range) of(EvaluateBarrier(gap, contact.range), distance, k);
  }
}

// One vertex at x stands for `area` of the cloth [m²]. It has the energy [J], the force f [N],
// scale times the positive semidefinite part H of −∂f/∂x [N/m], and ∂g/∂x of g(x; w) = h·f(x) −
// h²·H(x)·w with w held [MODEL, M31], which is not symmetric.
template <class Contact>
DRAPE_HD double VertexEnergy(const Contact& contact, double area, const Vec3<double>& x) {
  double energy = 0.0;
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance&, int) {
    energy += contact.stiffness * area * b.value;
  });
  return energy;
}
template <class Contact>
DRAPE_HD Vec3<double> VertexForce(const Contact& contact, double area, const Vec3<double>& x) {
  Vec3<double> force{0.0, 0.0, 0.0};
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance& d, int) {
    force = force - (contact.stiffness * area * b.slope) * d.normal;
  });
  return force;
}
template <class Contact>
DRAPE_HD void AddVertexStepStiffness(const Contact& contact, double area, const Vec3<double>& x,
                                     double scale, double (&block)[9]) {
  const double k = scale * contact.stiffness * area;
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance& d, int) {
    AddToBlock(k * b.curvature, d.normal, d.normal, block);
    AddToBlock(k * b.slope, d.blend, block);  // b' < 0
  });
}
template <class Contact>
DRAPE_HD void AddVertexStepDerivative(const Contact& contact, double area, const Vec3<double>& x,
                                      const Vec3<double>& w, double h, double (&block)[9]) {
  const double k = -contact.stiffness * area * h;
  ForEachNear(contact, x, [&](const Barrier& b, const SolidDistance& d, int obstacle) {
    const double speed = Dot(d.normal, w);
    AddToBlock(k * (b.curvature + h * b.third * speed), d.normal, d.normal, block);
    AddToBlock(k * (b.slope + h * b.curvature * speed), d.curvature, block);
    AddToBlock(k * h * b.curvature, d.normal, d.curvature * w, block);
    if (!(Trace(d.blend) < 0.0)) return;
    AddToBlock(k * h * b.curvature, d.blend * w, d.normal, block);
    contact.AddBlendChange(obstacle, x, w, k * h * b.slope, block);
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
// from the safe side. From any other, or out of the reach of a mesh, where there is no tangent, it
// changes by no more than x does.
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
    const bool has_tangent = is_convex && Dot(distance.normal, distance.normal) > 0.0;
    const double approach = has_tangent ? -Dot(distance.normal, dx) : std::sqrt(Dot(dx, dx));
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
