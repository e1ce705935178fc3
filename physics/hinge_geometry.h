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

// One wing: m = N̂/h [1/m] (unit normal over height) and t, the foot of its height along the edge.
// `side` is +1 for face 0, −1 for face 1, which traverses the edge backwards.
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

// Both wings of a hinge, shared by the gradient and the Hessian of θ.
template <class T>
struct WingPair {
  Vec3<T> edge, apex[2];  // relative to n0
  Wing<T> wing[2];
};
using HingeWings = WingPair<double>;
template <class T>
DRAPE_HD WingPair<T> EvaluateWings(const Vec3<T> (&x)[4]) {
  const Vec3<T> e = x[1] - x[0], a0 = x[2] - x[0], a1 = x[3] - x[0];
  return {e, {a0, a1}, {EvaluateWing(e, a0, 1.0), EvaluateWing(e, a1, -1.0)}};
}
DRAPE_HD inline HingeWings EvaluateWings(const HingeCorners& c) { return EvaluateWings(c.x); }

// ∂θ/∂x = [(t0−1)m0 + (t1−1)m1, −t0·m0 − t1·m1, m0, m1] [rad/m].
template <class T>
struct AngleGradientOf {
  Vec3<T> d[4];
};
using HingeGradient = AngleGradientOf<double>;
template <class T>
DRAPE_HD AngleGradientOf<T> AngleGradient(const WingPair<T>& hinge) {
  const Wing<T>&w0 = hinge.wing[0], &w1 = hinge.wing[1];
  return {{(w0.t - 1.0) * w0.m + (w1.t - 1.0) * w1.m, -w0.t * w0.m - w1.t * w1.m, w0.m, w1.m}};
}

DRAPE_HD inline double Dot(const HingeGradient& g, const HingeCorners& w) {
  return Dot(g.d[0], w.x[0]) + Dot(g.d[1], w.x[1]) + Dot(g.d[2], w.x[2]) + Dot(g.d[3], w.x[3]);
}

// Adds one wing's part of ∂²θ/∂x² to H [12][12]; `apex` is corner 2 or 3. From the derivatives of
// m and t by the apex a and the edge e, p = a − t·e the height, |p| = h:
//   ∂m/∂a = S = −(p mᵀ + m pᵀ)/h²,  ∂m/∂e = −t·S − e mᵀ/|e|²,
//   ∂t/∂a = e/|e|²,                 ∂t/∂e = (p − t·e)/|e|².
// Rows and columns of n0 follow because they sum to zero.
DRAPE_HD inline void AddWingHessian(const Vec3<double>& edge, const Vec3<double>& apex_at,
                                    const Wing<double>& wing, int apex, double H[12][12]) {
  const double t = wing.t, inverse_h2 = Dot(wing.m, wing.m), inverse_ee = 1.0 / Dot(edge, edge);
  const Vec3<double> height = apex_at - t * edge, t_by_e = inverse_ee * (height - t * edge);
  const Vec3<double> t_by_a = inverse_ee * edge;
  const double *m = &wing.m.x, *p = &height.x, *ta = &t_by_a.x, *te = &t_by_e.x;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const double m_by_a = -inverse_h2 * (p[i] * m[k] + m[i] * p[k]);
      const double m_by_e = -t * m_by_a - ta[i] * m[k];
      const double n1_by_a = -m[i] * ta[k] - t * m_by_a, n1_by_e = -m[i] * te[k] - t * m_by_e;
      double *row0 = H[i], *row1 = H[3 + i], *row = H[3 * apex + i];
      row[3 * apex + k] += m_by_a;
      row[3 + k] += m_by_e;
      row[k] -= m_by_a + m_by_e;
      row1[3 * apex + k] += n1_by_a;
      row1[3 + k] += n1_by_e;
      row1[k] -= n1_by_a + n1_by_e;
      row0[3 * apex + k] -= m_by_a + n1_by_a;
      row0[3 + k] -= m_by_e + n1_by_e;
      row0[k] += m_by_a + m_by_e + n1_by_a + n1_by_e;
    }
}

// ∂²θ/∂x² [rad/m²], shape [12, 12], symmetric.
DRAPE_HD inline void AngleHessian(const HingeWings& hinge, double H[12][12]) {
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) H[i][j] = 0.0;
  AddWingHessian(hinge.edge, hinge.apex[0], hinge.wing[0], 2, H);
  AddWingHessian(hinge.edge, hinge.apex[1], hinge.wing[1], 3, H);
}

// The same for two directions only: ∂θ/∂x with its rates ∂²θ/∂x²·v along v = `along[0]`,
// `along[1]`.
DRAPE_HD inline AngleGradientOf<Dual<2>> AngleGradientRates(const HingeCorners& c,
                                                            const HingeCorners (&along)[2]) {
  Vec3<Dual<2>> x[4];
  for (int i = 0; i < 12; ++i) {
    Dual<2>& entry = (&x[i / 3].x)[i % 3];
    entry.a = (&c.x[i / 3].x)[i % 3];
    for (int k = 0; k < 2; ++k) entry.v[k] = (&along[k].x[i / 3].x)[i % 3];
  }
  return AngleGradient(EvaluateWings(x));
}

}  // namespace drape
