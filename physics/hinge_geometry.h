// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/dual.h"
#include "physics/mesh.h"
#include "physics/vec3.h"

namespace drape {

// Geometry of one hinge (SPEC section 3, fact 6): vertices n0, n1, opposite 0, opposite 1.

struct HingeCorners {
  Vec3<double> x[4];
};

DRAPE_HD inline HingeCorners GatherCorners(const Hinge& hinge, const double* nodes) {
  return {{LoadVec3(nodes, hinge.vertex[0]), LoadVec3(nodes, hinge.vertex[1]),
           LoadVec3(nodes, hinge.vertex[2]), LoadVec3(nodes, hinge.vertex[3])}};
}

// One wing: m = N/h [1/m] (normal over height squared, times height) and t, the foot of its
// height along the edge. `side` is +1 for face 0, −1 for face 1, which traverses the edge backwards.
template <class T>
struct Wing {
  Vec3<T> m;
  T t;
};
template <class T>
DRAPE_HD Wing<T> EvaluateWing(const Vec3<T>& edge, const Vec3<T>& apex, double side) {
  using std::sqrt;
  const Vec3<T> N = side * Cross(edge, apex);
  const T ee = Dot(edge, edge);
  return {(sqrt(ee) / Dot(N, N)) * N, Dot(edge, apex) / ee};
}

// θ = atan2(ê·(N0×N1), N0·N1), ê = unit(x_n0 − x_n1) [rad].
DRAPE_HD inline double DihedralAngle(const HingeCorners& c) {
  const Vec3<double> e = c.x[1] - c.x[0];
  const Vec3<double> N0 = Cross(e, c.x[2] - c.x[0]), N1 = Cross(c.x[3] - c.x[0], e);
  return std::atan2(-Dot(e, Cross(N0, N1)) / std::sqrt(Dot(e, e)), Dot(N0, N1));
}

// ∂θ/∂x = [(t0−1)m0 + (t1−1)m1, −t0·m0 − t1·m1, m0, m1] [rad/m].
struct HingeGradient {
  Vec3<double> d[4];
};
DRAPE_HD inline HingeGradient AngleGradient(const HingeCorners& c) {
  const Vec3<double> e = c.x[1] - c.x[0];
  const Wing<double> w0 = EvaluateWing(e, c.x[2] - c.x[0], 1.0);
  const Wing<double> w1 = EvaluateWing(e, c.x[3] - c.x[0], -1.0);
  return {{(w0.t - 1.0) * w0.m + (w1.t - 1.0) * w1.m, -w0.t * w0.m - w1.t * w1.m, w0.m, w1.m}};
}

DRAPE_HD inline double Dot(const HingeGradient& g, const HingeCorners& w) {
  return Dot(g.d[0], w.x[0]) + Dot(g.d[1], w.x[1]) + Dot(g.d[2], w.x[2]) + Dot(g.d[3], w.x[3]);
}

// Adds one wing's part of ∂²θ/∂x² to H [12][12]; corner 3 or 2 is its apex.
DRAPE_HD inline void AddWingHessian(const HingeCorners& c, int apex, double H[12][12]) {
  using D = Dual<6>;
  const Vec3<double> e = c.x[1] - c.x[0], a = c.x[apex] - c.x[0];
  const Wing<D> w = EvaluateWing<D>({D(e.x, 0), D(e.y, 1), D(e.z, 2)},
                                    {D(a.x, 3), D(a.y, 4), D(a.z, 5)}, apex == 2 ? 1.0 : -1.0);
  const Vec3<D> at_n0 = (w.t - 1.0) * w.m, at_n1 = -w.t * w.m;
  const D* rows[9] = {&at_n0.x, &at_n0.y, &at_n0.z, &at_n1.x, &at_n1.y,
                      &at_n1.z, &w.m.x,   &w.m.y,   &w.m.z};
  for (int r = 0; r < 9; ++r) {
    double* out = H[r < 6 ? r : 3 * apex + r - 6];
    for (int k = 0; k < 3; ++k) {
      const double by_edge = rows[r]->v[k], by_apex = rows[r]->v[3 + k];
      out[k] -= by_edge + by_apex;
      out[3 + k] += by_edge;
      out[3 * apex + k] += by_apex;
    }
  }
}

// ∂²θ/∂x² [rad/m²], shape [12, 12].
DRAPE_HD inline void AngleHessian(const HingeCorners& c, double H[12][12]) {
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) H[i][j] = 0.0;
  AddWingHessian(c, 2, H);
  AddWingHessian(c, 3, H);
}

}  // namespace drape
