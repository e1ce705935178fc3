// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/material/material.h"
#include "physics/mesh/mesh.h"
#include "physics/util/math/host_device.h"

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

// The two wings of a hinge, which the gradient and the Hessian of θ share.
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

// One hinge [MODEL, M13]: its moment is −κ(θ)·μ(θ) with κ = B(θ)·l²/(4A) [N·m/rad], where A is its
// rest area and μ the law's measure of the angle. HingeFactor is κ/B [rad⁻¹].
DRAPE_HD inline double HingeFactor(const Hinge& hinge) {
  return hinge.rest_length * hinge.rest_length / (4.0 * hinge.rest_area);
}

// The two table rows that bracket the edge direction, and their weights [MODEL, M2].
struct BendRows {
  int first;
  double weight[2];
};
DRAPE_HD inline BendRows SelectRows(const Hinge& hinge) {
  const int first = hinge.direction < 1.0 ? 0 : 1;
  const double t = hinge.direction - first;
  return {first, {1.0 - t, t}};
}

// Weights of the N table columns around a curvature. The same column may occur twice.
template <class T, int N>
struct ColumnWeights {
  int column[N];
  T weight[N];
};

template <class Law, class T, int N>
DRAPE_HD T HingeStiffness(const Law& law, const Hinge& hinge, const BendTable& table,
                          const ColumnWeights<T, N>& columns) {
  const BendRows rows = SelectRows(hinge);
  const double *low = table.b[rows.first], *high = table.b[rows.first + 1];
  T B(0.0);
  for (int i = 0; i < N; ++i) {
    const int c = columns.column[i];
    B += columns.weight[i] * (rows.weight[0] * low[c] + rows.weight[1] * high[c]);
  }
  return law.Active(Value(B)) ? B * HingeFactor(hinge) : T(0.0);
}
template <class Law, class T>
DRAPE_HD T HingeStiffness(const Law& law, const Hinge& hinge, const BendTable& table,
                          const T& theta) {
  return HingeStiffness(law, hinge, table, law.Columns(hinge, theta));
}

// ∂κ/∂(table entry), shape [3, 5] [rad⁻¹]; zero where the law's clamp holds κ at zero.
template <class Law>
DRAPE_HD void HingeStiffnessByTable(const Law& law, const Hinge& hinge, const BendTable& table,
                                    double theta, double by_entry[kBendRows][kBendCols]) {
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c) by_entry[r][c] = 0.0;
  const auto columns = law.Columns(hinge, theta);
  if (!law.Active(HingeStiffness(law, hinge, table, columns))) return;
  const BendRows rows = SelectRows(hinge);
  for (int k = 0; k < 2; ++k)
    for (int i = 0; i < Law::kColumns; ++i)
      by_entry[rows.first + k][columns.column[i]] +=
          rows.weight[k] * columns.weight[i] * HingeFactor(hinge);
}

// What Law::Measure returns: an odd function μ(θ) ≈ θ [rad], ∂μ/∂θ > 0 and ∂²μ/∂θ².
struct HingeMeasure {
  double value, slope, curvature;
};

// The step force g = h·f − h²·H·w of a hinge is −s·∂θ/∂x with s = κ·(h·μ + h²·μ′·q) and
// q = ∂θ/∂x·w [MODEL, M31]. StepMoment is s.
DRAPE_HD inline double StepMoment(double kappa, const HingeMeasure& mu, double q, double h) {
  return kappa * (h * mu.value + h * h * mu.slope * q);
}
// ∂s/∂θ at a fixed q.
DRAPE_HD inline double StepMomentByTheta(const Dual<1>& kappa, const HingeMeasure& mu, double q,
                                         double h) {
  return StepMoment(kappa.v[0], mu, q, h) + kappa.a * (h * mu.slope + h * h * mu.curvature * q);
}

// ∂g/∂x with w held, shape [12, 12]: −∂θ ⊗ ∇s − s·∂²θ [MODEL, M39].
template <class Law>
DRAPE_HD void BendStepDerivative(const Law& law, const Hinge& hinge, const BendTable& table,
                                 const HingeCorners& x, const HingeCorners& w, double h,
                                 double out[12][12]) {
  const double theta = DihedralAngle(x);
  const HingeWings wings = EvaluateWings(x);
  const HingeGradient d = AngleGradient(wings);
  const Dual<1> kappa = HingeStiffness(law, hinge, table, Dual<1>(theta, 0));
  AngleHessian(wings, out);
  const double* grad = &d.d[0].x;
  const double* direction = &w.x[0].x;
  const HingeMeasure mu = law.Measure(theta);
  const double q = Dot(d, w), s = StepMoment(kappa.a, mu, q, h);
  const double s_by_theta = StepMomentByTheta(kappa, mu, q, h);
  double grad_s[12];
  for (int j = 0; j < 12; ++j) grad_s[j] = s_by_theta * grad[j];
  for (int i = 0; i < 12; ++i)  // + h²κμ′·∂²θ·w
    for (int j = 0; j < 12; ++j) grad_s[j] += h * h * kappa.a * mu.slope * direction[i] * out[i][j];
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j) out[i][j] = -grad[i] * grad_s[j] - s * out[i][j];
}

// The parts of ∂g/∂x from which single blocks are computed.
struct BendStepRates {
  HingeGradient grad, grad_s;
  double s;
  WingRates wing[2];
};
template <class Law>
DRAPE_HD BendStepRates EvaluateBendStepRates(const Law& law, const Hinge& hinge,
                                             const BendTable& table, const HingeCorners& x,
                                             const HingeCorners& w, double h) {
  const double theta = DihedralAngle(x);
  const HingeWings wings = EvaluateWings(x);
  const AngleGradientOf<Dual<1>> along_w = AngleGradientRates<1>(x, {w});
  const Dual<1> kappa = HingeStiffness(law, hinge, table, Dual<1>(theta, 0));
  BendStepRates rates;
  rates.grad = AngleGradient(wings);
  const double q = Dot(rates.grad, w);
  const HingeMeasure mu = law.Measure(theta);
  rates.s = StepMoment(kappa.a, mu, q, h);
  const double s_by_theta = StepMomentByTheta(kappa, mu, q, h);
  for (int i = 0; i < 12; ++i)
    (&rates.grad_s.d[0].x)[i] = s_by_theta * (&rates.grad.d[0].x)[i] +
                                h * h * kappa.a * mu.slope * (&along_w.d[0].x)[i].v[0];
  for (int side = 0; side < 2; ++side)
    rates.wing[side] = ComputeRates(wings.edge, wings.apex[side], wings.wing[side]);
  return rates;
}
// Adds the blocks (a, b) and (b, a) of ∂g/∂x, shape [3, 3] each. The second one has no use when
// both corners are the same.
DRAPE_HD inline void AddBendStepBlocks(const BendStepRates& rates, int a, int b, double at_ab[9],
                                       double at_ba[9]) {
  double hessian[9] = {};
  for (int side = 0; side < 2; ++side)
    AddWingHessianBlock(rates.wing[side], 2 + side, a, b, rates.s, hessian);
  const double *grad_a = &rates.grad.d[a].x, *grad_b = &rates.grad.d[b].x;
  const double *s_a = &rates.grad_s.d[a].x, *s_b = &rates.grad_s.d[b].x;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      at_ab[3 * i + k] -= grad_a[i] * s_b[k] + hessian[3 * i + k];
      at_ba[3 * i + k] -= grad_b[i] * s_a[k] + hessian[3 * k + i];
    }
}

// Adjoint of the step force of one hinge: adj_x = (∂g/∂x)ᵀ·λ, shape [12], and ∂(g·λ)/∂κ.
struct BendAdjoint {
  double adj_x[12];
  double adj_kappa;
};
template <class Law>
DRAPE_HD BendAdjoint AdjBendStep(const Law& law, const Hinge& hinge, const BendTable& table,
                                 const HingeCorners& x, const HingeCorners& w, double h,
                                 const HingeCorners& lambda, double theta) {
  const AngleGradientOf<Dual<2>> gradient = AngleGradientRates<2>(x, {w, lambda});
  const Dual<2>* d = &gradient.d[0].x;
  const double *w_at = &w.x[0].x, *lambda_at = &lambda.x[0].x;
  double q = 0.0, l = 0.0;
  for (int i = 0; i < 12; ++i) q += d[i].a * w_at[i], l += d[i].a * lambda_at[i];
  const Dual<1> kappa = HingeStiffness(law, hinge, table, Dual<1>(theta, 0));
  const HingeMeasure mu = law.Measure(theta);
  const double s = StepMoment(kappa.a, mu, q, h);
  const double along_d = -l * StepMomentByTheta(kappa, mu, q, h);
  const double along_w = -l * h * h * kappa.a * mu.slope;
  BendAdjoint result;
  for (int i = 0; i < 12; ++i)
    result.adj_x[i] = along_d * d[i].a + along_w * d[i].v[0] - s * d[i].v[1];
  result.adj_kappa = -l * StepMoment(1.0, mu, q, h);
  return result;
}

// W(θ) = ∫₀^θ κ(t)·μ(t) dt [J] [MODEL, M15] by Gauss–Legendre quadrature on each smooth piece with
// five points. Three points are exact for the cubic of the reference law; five leave an error of
// 1e-13 for the smooth law.
template <class Law>
DRAPE_HD double BendEnergy(const Law& law, const Hinge& hinge, const BendTable& table,
                           double theta) {
  constexpr double kNode[5] = {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                               0.9061798459386640};
  constexpr double kWeight[5] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                 0.4786286704993665, 0.2369268850561891};
  const double sign = theta < 0.0 ? -1.0 : 1.0;
  double energy = 0.0, from = 0.0;
  for (int knot = 0; knot <= kBendCols && from < sign * theta; ++knot) {
    const double end = knot < kBendCols ? law.KnotAngle(hinge, knot) : M_PI;
    const double to = end < sign * theta ? end : sign * theta, half = 0.5 * (to - from);
    for (int i = 0; i < 5; ++i) {
      const double t = sign * (from + half * (1.0 + kNode[i]));
      energy +=
          half * kWeight[i] * sign * law.Measure(t).value * HingeStiffness(law, hinge, table, t);
    }
    from = to;
  }
  return energy;
}

}  // namespace drape
