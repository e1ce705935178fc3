// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/mesh/mesh.h"
#include "physics/util/math/dual.h"
#include "physics/util/math/vec3.h"

namespace drape {

// Geometry of one hinge [MODEL, M5, M6]. The vertices are n0, n1, opposite 0, opposite 1.

struct HingeCorners {
  Vec3<double> x[4];
};

DRAPE_HD inline HingeCorners GatherCorners(const Hinge& hinge, const double* nodes) {
  return {{LoadVec3(nodes, hinge.vertex[0]), LoadVec3(nodes, hinge.vertex[1]),
           LoadVec3(nodes, hinge.vertex[2]), LoadVec3(nodes, hinge.vertex[3])}};
}

// One wing: m = N̂/h [1/m] (the unit normal over the height) and t, the foot of the height along
// the edge [MODEL, M6]. `side` is +1 for face 0 and −1 for face 1, which traverses the edge
// backwards.
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

// The dihedral angle θ = atan2(ê·(N0×N1), N0·N1) with ê = unit(x_n0 − x_n1) [rad] [MODEL, M5].
DRAPE_HD inline double DihedralAngle(const HingeCorners& c) {
  const Vec3<double> e = c.x[1] - c.x[0];
  const Vec3<double> N0 = Cross(e, c.x[2] - c.x[0]), N1 = Cross(c.x[3] - c.x[0], e);
  return std::atan2(-Dot(e, Cross(N0, N1)) / std::sqrt(Dot(e, e)), Dot(N0, N1));
}

// Both wings of a hinge, which the gradient and the Hessian of θ share.
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

// ∂θ/∂x = [(t0−1)m0 + (t1−1)m1, −t0·m0 − t1·m1, m0, m1] [rad/m] [MODEL, M6].
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

// The terms of the contribution of one wing to ∂²θ/∂x² [MODEL, M6]. They follow from the
// derivatives of m and t by the apex a and the edge e, where p = a − t·e is the height and |p| = h:
//   ∂m/∂a = S = −(p mᵀ + m pᵀ)/h²,  ∂m/∂e = −t·S − e mᵀ/|e|²,
//   ∂t/∂a = e/|e|²,                 ∂t/∂e = (p − t·e)/|e|².
struct WingRates {
  Vec3<double> m, height, t_by_a, t_by_e;
  double t, inverse_h2;
};
DRAPE_HD inline WingRates ComputeRates(const Vec3<double>& edge, const Vec3<double>& apex,
                                       const Wing<double>& wing) {
  const double inverse_ee = 1.0 / Dot(edge, edge);
  const Vec3<double> height = apex - wing.t * edge;
  return {wing.m,
          height,
          inverse_ee * edge,
          inverse_ee * (height - wing.t * edge),
          wing.t,
          Dot(wing.m, wing.m)};
}
// Entry (i, k) of the derivatives of ∂θ/∂apex = m and ∂θ/∂n1 = −t·m by apex and edge.
struct WingEntry {
  double m_by_a, m_by_e, n1_by_a, n1_by_e;
};
DRAPE_INLINE WingEntry WingRateEntry(const WingRates& r, int i, int k) {
  const double *m = &r.m.x, *p = &r.height.x, *ta = &r.t_by_a.x, *te = &r.t_by_e.x;
  WingEntry entry;
  entry.m_by_a = -r.inverse_h2 * (p[i] * m[k] + m[i] * p[k]);
  entry.m_by_e = -r.t * entry.m_by_a - ta[i] * m[k];
  entry.n1_by_a = -m[i] * ta[k] - r.t * entry.m_by_a;
  entry.n1_by_e = -m[i] * te[k] - r.t * entry.m_by_e;
  return entry;
}

// Adds the contribution of one wing to ∂²θ/∂x² to H [12][12]; `apex` is corner 2 or 3. The rows and
// columns of n0 follow because all rows and columns sum to zero.
DRAPE_HD inline void AddWingHessian(const WingRates& rates, int apex, double H[12][12]) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const WingEntry d = WingRateEntry(rates, i, k);
      double *row0 = H[i], *row1 = H[3 + i], *row = H[3 * apex + i];
      row[3 * apex + k] += d.m_by_a;
      row[3 + k] += d.m_by_e;
      row[k] -= d.m_by_a + d.m_by_e;
      row1[3 * apex + k] += d.n1_by_a;
      row1[3 + k] += d.n1_by_e;
      row1[k] -= d.n1_by_a + d.n1_by_e;
      row0[3 * apex + k] -= d.m_by_a + d.n1_by_a;
      row0[3 + k] -= d.m_by_e + d.n1_by_e;
      row0[k] += d.m_by_a + d.m_by_e + d.n1_by_a + d.n1_by_e;
    }
}

// Adds block (a, b) of the same matrix, times `scale`, to out [3, 3].
DRAPE_HD inline void AddWingHessianBlock(const WingRates& rates, int apex, int a, int b,
                                         double scale, double out[9]) {
  // Derivatives of a corner by the apex and by n1, both relative to n0.
  const auto by_apex = [&](int corner) { return corner == 0 ? -1.0 : corner == apex ? 1.0 : 0.0; };
  const auto by_n1 = [](int corner) { return corner == 0 ? -1.0 : corner == 1 ? 1.0 : 0.0; };
  const double m = scale * by_apex(a), n1 = scale * by_n1(a);
  const double to_a = by_apex(b), to_e = by_n1(b);
  if ((m == 0.0 && n1 == 0.0) || (to_a == 0.0 && to_e == 0.0)) return;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const WingEntry d = WingRateEntry(rates, i, k);
      out[3 * i + k] +=
          to_a * (m * d.m_by_a + n1 * d.n1_by_a) + to_e * (m * d.m_by_e + n1 * d.n1_by_e);
    }
}

// ∂²θ/∂x² [rad/m²], shape [12, 12], symmetric.
DRAPE_HD inline void AngleHessian(const HingeWings& hinge, double H[12][12]) {
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) H[i][j] = 0.0;
  for (int side = 0; side < 2; ++side)
    AddWingHessian(ComputeRates(hinge.edge, hinge.apex[side], hinge.wing[side]), 2 + side, H);
}

// The products of the same matrix with N directions only: ∂θ/∂x and its rates ∂²θ/∂x²·v along v =
// along[0] …
template <int N>
DRAPE_HD AngleGradientOf<Dual<N>> AngleGradientRates(const HingeCorners& c,
                                                     const HingeCorners (&along)[N]) {
  Vec3<Dual<N>> x[4];
  for (int i = 0; i < 12; ++i) {
    Dual<N>& entry = (&x[i / 3].x)[i % 3];
    entry.a = (&c.x[i / 3].x)[i % 3];
    for (int k = 0; k < N; ++k) entry.v[k] = (&along[k].x[i / 3].x)[i % 3];
  }
  return AngleGradient(EvaluateWings(x));
}

}  // namespace drape
