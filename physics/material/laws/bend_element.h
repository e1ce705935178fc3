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
struct HingeWings {
  Vec3<double> edge, apex[2];  // relative to n0
  Wing<double> wing[2];
};
DRAPE_HD inline HingeWings EvaluateWings(const HingeCorners& c) {
  const Vec3<double> e = c.x[1] - c.x[0], a0 = c.x[2] - c.x[0], a1 = c.x[3] - c.x[0];
  return {e, {a0, a1}, {EvaluateWing(e, a0, 1.0), EvaluateWing(e, a1, -1.0)}};
}

// ∂θ/∂x = [(t0−1)m0 + (t1−1)m1, −t0·m0 − t1·m1, m0, m1] [rad/m] [MODEL, M6].
struct HingeGradient {
  Vec3<double> d[4];
};
DRAPE_HD inline HingeGradient AngleGradient(const HingeWings& hinge) {
  const Wing<double>&w0 = hinge.wing[0], &w1 = hinge.wing[1];
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
// Entry (i, k) of the derivatives of ∂θ/∂apex = m and ∂θ/∂n1 = −t·m by apex and edge. T: double, or
// a vector of entries.
template <class T>
struct WingEntry {
  T m_by_a, m_by_e, n1_by_a, n1_by_e;
};
template <class T>
DRAPE_INLINE WingEntry<T> WingRateEntry(double inverse_h2, double t, const T& p_i, const T& m_i,
                                        const T& ta_i, const T& p_k, const T& m_k, const T& ta_k,
                                        const T& te_k) {
  WingEntry<T> entry;
  entry.m_by_a = -inverse_h2 * (p_i * m_k + m_i * p_k);
  entry.m_by_e = -t * entry.m_by_a - ta_i * m_k;
  entry.n1_by_a = -m_i * ta_k - t * entry.m_by_a;
  entry.n1_by_e = -m_i * te_k - t * entry.m_by_e;
  return entry;
}
DRAPE_INLINE WingEntry<double> WingRateEntry(const WingRates& r, int i, int k) {
  const double *m = &r.m.x, *p = &r.height.x, *ta = &r.t_by_a.x, *te = &r.t_by_e.x;
  return WingRateEntry(r.inverse_h2, r.t, p[i], m[i], ta[i], p[k], m[k], ta[k], te[k]);
}

// Adds block (a, b) of the contribution of one wing to ∂²θ/∂x², times `scale`, to out [3, 3];
// `apex` is corner 2 or 3. The rows and columns of n0 follow because all rows and columns sum to
// zero.
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
      const WingEntry<double> d = WingRateEntry(rates, i, k);
      out[3 * i + k] +=
          to_a * (m * d.m_by_a + n1 * d.n1_by_a) + to_e * (m * d.m_by_e + n1 * d.n1_by_e);
    }
}

// The rates of both wings.
struct HingeRates {
  WingRates wing[2];
};
DRAPE_HD inline HingeRates ComputeRates(const HingeWings& hinge) {
  return {{ComputeRates(hinge.edge, hinge.apex[0], hinge.wing[0]),
           ComputeRates(hinge.edge, hinge.apex[1], hinge.wing[1])}};
}

// ∂²θ/∂x²·v [rad/m].
DRAPE_HD inline HingeGradient operator*(const HingeRates& rates, const HingeCorners& v) {
  HingeGradient product;
  product.d[1] = {0.0, 0.0, 0.0};
  const Vec3<double> e = v.x[1] - v.x[0];
  for (int side = 0; side < 2; ++side) {
    const WingRates& r = rates.wing[side];
    const Vec3<double> a = v.x[2 + side] - v.x[0], height = a - r.t * e;
    const Vec3<double> m = (-r.inverse_h2 * Dot(r.m, height)) * r.height +
                           (-r.inverse_h2 * Dot(r.height, height)) * r.m - Dot(r.m, e) * r.t_by_a;
    product.d[2 + side] = m;
    product.d[1] = product.d[1] - ((Dot(r.t_by_a, a) + Dot(r.t_by_e, e)) * r.m + r.t * m);
  }
  product.d[0] = -1.0 * (product.d[1] + product.d[2] + product.d[3]);
  return product;
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
template <class Law, class T, int N>
DRAPE_HD void HingeStiffnessByTable(const Law& law, const Hinge& hinge, const BendTable& table,
                                    const ColumnWeights<T, N>& columns,
                                    double by_entry[kBendRows][kBendCols]) {
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c) by_entry[r][c] = 0.0;
  if (!law.Active(Value(HingeStiffness(law, hinge, table, columns)))) return;
  const BendRows rows = SelectRows(hinge);
  for (int k = 0; k < 2; ++k)
    for (int i = 0; i < N; ++i)
      by_entry[rows.first + k][columns.column[i]] +=
          rows.weight[k] * Value(columns.weight[i]) * HingeFactor(hinge);
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

// The parts of ∂g/∂x with w held, −∂θ ⊗ ∇s − s·∂²θ [MODEL, M39], from which blocks are computed.
struct BendStepRates {
  HingeGradient grad, grad_s;
  double s;
  HingeRates hessian;
};
template <class Law>
DRAPE_HD BendStepRates EvaluateBendStepRates(const Law& law, const Hinge& hinge,
                                             const BendTable& table, const HingeCorners& x,
                                             const HingeCorners& w, double h) {
  const double theta = DihedralAngle(x);
  const HingeWings wings = EvaluateWings(x);
  const Dual<1> kappa = HingeStiffness(law, hinge, table, Dual<1>(theta, 0));
  BendStepRates rates{AngleGradient(wings), {}, 0.0, ComputeRates(wings)};
  const double q = Dot(rates.grad, w);
  const HingeMeasure mu = law.Measure(theta);
  rates.s = StepMoment(kappa.a, mu, q, h);
  const double s_by_theta = StepMomentByTheta(kappa, mu, q, h);
  const HingeGradient along_w = rates.hessian * w;
  for (int a = 0; a < 4; ++a)
    rates.grad_s.d[a] = s_by_theta * rates.grad.d[a] + (h * h * kappa.a * mu.slope) * along_w.d[a];
  return rates;
}
// Adds the blocks (a, b) and (b, a) of ∂g/∂x, shape [3, 3] each. The second one has no use when
// both corners are the same.
DRAPE_HD inline void AddBendStepBlocks(const BendStepRates& rates, int a, int b, double at_ab[9],
                                       double at_ba[9]) {
  double hessian[9] = {};
  for (int side = 0; side < 2; ++side)
    AddWingHessianBlock(rates.hessian.wing[side], 2 + side, a, b, rates.s, hessian);
  const double *grad_a = &rates.grad.d[a].x, *grad_b = &rates.grad.d[b].x;
  const double *s_a = &rates.grad_s.d[a].x, *s_b = &rates.grad_s.d[b].x;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      at_ab[3 * i + k] -= grad_a[i] * s_b[k] + hessian[3 * i + k];
      at_ba[3 * i + k] -= grad_b[i] * s_a[k] + hessian[3 * k + i];
    }
}

// ∂g/∂x with w held, shape [12, 12].
template <class Law>
DRAPE_HD void BendStepDerivative(const Law& law, const Hinge& hinge, const BendTable& table,
                                 const HingeCorners& x, const HingeCorners& w, double h,
                                 double out[12][12]) {
  const BendStepRates rates = EvaluateBendStepRates(law, hinge, table, x, w, h);
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b <= a; ++b) {
      double at_ab[9] = {}, at_ba[9] = {};
      AddBendStepBlocks(rates, a, b, at_ab, at_ba);
      for (int i = 0; i < 9; ++i) {
        out[3 * b + i / 3][3 * a + i % 3] = at_ba[i];
        out[3 * a + i / 3][3 * b + i % 3] = at_ab[i];
      }
    }
}

// Adjoint of the step force of one hinge: adj_x = (∂g/∂x)ᵀ·λ and ∂(g·λ)/∂κ. columns: the law's at
// the angle θ of x. stiffness_work, unless it is null: λ·H·w.
struct BendAdjoint {
  HingeGradient adj_x;
  double adj_kappa;
};
template <class Law>
DRAPE_HD BendAdjoint AdjBendStep(const Law& law, const Hinge& hinge, const BendTable& table,
                                 const ColumnWeights<Dual<1>, Law::kColumns>& columns,
                                 const HingeCorners& x, const HingeCorners& w, double h,
                                 const HingeCorners& lambda, double theta,
                                 double* stiffness_work = nullptr) {
  const HingeWings wings = EvaluateWings(x);
  const HingeGradient d = AngleGradient(wings);
  const HingeRates hessian = ComputeRates(wings);
  const HingeGradient by_w = hessian * w, by_lambda = hessian * lambda;
  const double q = Dot(d, w), l = Dot(d, lambda);
  const Dual<1> kappa = HingeStiffness(law, hinge, table, columns);
  const HingeMeasure mu = law.Measure(theta);
  const double s = StepMoment(kappa.a, mu, q, h);
  const double along_d = -l * StepMomentByTheta(kappa, mu, q, h);
  const double along_w = -l * h * h * kappa.a * mu.slope;
  if (stiffness_work != nullptr) *stiffness_work = kappa.a * mu.slope * q * l;
  BendAdjoint result{{}, -l * StepMoment(1.0, mu, q, h)};
  for (int a = 0; a < 4; ++a)
    result.adj_x.d[a] = along_d * d.d[a] + along_w * by_w.d[a] - s * by_lambda.d[a];
  return result;
}

// W(θ) = ∫₀^θ κ(t)·μ(t) dt [J] [MODEL, M15] by Gauss–Legendre quadrature on each smooth piece.
// Three points are exact for the cubic of the reference law. For the smooth law, four leave an
// error of 1e-13 on a narrow piece and five on a wide one.
template <class Law>
DRAPE_HD double BendEnergy(const Law& law, const Hinge& hinge, const BendTable& table,
                           double theta) {
  constexpr int kMostNodes = 5;
  constexpr double kNarrow = 0.05;  // half of its angle [rad]
  constexpr double kNode[2][kMostNodes] = {
      {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526},
      {-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831, 0.9061798459386640}};
  constexpr double kWeight[2][kMostNodes] = {
      {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538},
      {0.2369268850561891, 0.4786286704993665, 0.5688888888888889, 0.4786286704993665,
       0.2369268850561891}};
  const BendRows rows = SelectRows(hinge);
  double B[kBendCols];
  for (int c = 0; c < kBendCols; ++c)
    B[c] = rows.weight[0] * table.b[rows.first][c] + rows.weight[1] * table.b[rows.first + 1][c];
  const double sign = theta < 0.0 ? -1.0 : 1.0, whole = sign * theta;
  const int knots = law.CountKnots(hinge, whole);
  double energy = 0.0, from = 0.0;
  for (int knot = 0; knot <= knots; ++knot) {
    const double to = knot < knots ? law.KnotAngle(hinge, knot) : whole, half = 0.5 * (to - from);
    const int rule = half < kNarrow ? 0 : 1;
    for (int i = 0; i < 4 + rule; ++i) {
      const double t = sign * (from + half * (1.0 + kNode[rule][i]));
      const auto columns = law.Columns(hinge, t);
      double at = 0.0;
      for (int k = 0; k < Law::kColumns; ++k) at += columns.weight[k] * B[columns.column[k]];
      if (law.Active(at)) energy += half * kWeight[rule][i] * sign * law.Measure(t).value * at;
    }
    from = to;
  }
  return energy * HingeFactor(hinge);
}

}  // namespace drape
