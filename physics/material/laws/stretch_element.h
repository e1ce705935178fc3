// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/material.h"
#include "physics/mesh/mesh.h"
#include "physics/util/math/host_device.h"

namespace drape {

// One triangle as a function of its deformation gradient [MODEL, M4, M10, M11].

// The columns of the deformation gradient F, shape [3, 2], no unit.
template <class T>
struct DeformationGradient {
  Vec3<T> u, v;
};

// The Green strain G = ½(FᵀF − I), no unit [MODEL, M4].
template <class T>
struct GreenStrain {
  T uu, vv, uv;
};

template <class T>
DRAPE_HD GreenStrain<T> Green(const DeformationGradient<T>& F) {
  return {T(0.5 * (Dot(F.u, F.u) - 1.0)), T(0.5 * (Dot(F.v, F.v) - 1.0)), T(0.5 * Dot(F.u, F.v))};
}

// The four stiffnesses at a strain [N/m], and the ramped strains ⟨G⟩ that the step matrix uses
// [MODEL, M11].
template <class T>
struct StretchCoefficients {
  T c11, c12, c22, c33;
  GreenStrain<T> G;
  T ramp_uu, ramp_vv;
};

// by_entry: the derivatives of each stiffness by its table entries [1], shape [6, 4], or null.
template <class Law, class T>
DRAPE_HD StretchCoefficients<T> EvaluateStretch(const Law& law, const GreenStrain<T>& G,
                                                const StretchTable& table,
                                                double (*by_entry)[kStretchCols] = nullptr) {
  T c[kStretchCols];
  law.Stiffness(G, table, c, by_entry);
  return {c[0], c[1], c[2], c[3], G, law.Ramp(G.uu), law.Ramp(G.vv)};
}

template <int N>
DRAPE_HD StretchCoefficients<double> Values(const StretchCoefficients<Dual<N>>& k) {
  return {k.c11.a,     k.c12.a,    k.c22.a, k.c33.a, {k.G.uu.a, k.G.vv.a, k.G.uv.a},
          k.ramp_uu.a, k.ramp_vv.a};
}

// The stress S of a strain at given stiffnesses, symmetric [N/m] [MODEL, M10].
template <class T>
struct StretchStress {
  T uu, vv, uv;
};
template <class T>
DRAPE_HD StretchStress<T> Stress(const StretchCoefficients<T>& k, const GreenStrain<T>& G) {
  return {k.c11 * G.uu + k.c12 * G.vv, k.c22 * G.vv + k.c12 * G.uu, k.c33 * G.uv};
}
template <int N>
DRAPE_HD StretchStress<double> Values(const StretchStress<Dual<N>>& S) {
  return {S.uu.a, S.vv.a, S.uv.a};
}
// F·S, the columns that Du and Dv carry to the vertices.
template <class T>
DRAPE_HD DeformationGradient<T> operator*(const DeformationGradient<T>& F,
                                          const StretchStress<T>& S) {
  return {S.uu * F.u + S.uv * F.v, S.vv * F.v + S.uv * F.u};
}

// The force by rest area, −F·S(G) [N/m] [MODEL, M10].
template <class T>
DRAPE_HD DeformationGradient<T> StretchForce(const StretchCoefficients<T>& k,
                                             const DeformationGradient<T>& F) {
  const StretchStress<T> S = Stress(k, k.G);
  return F * StretchStress<T>{-S.uu, -S.vv, -S.uv};
}

// S(G) with ∂S/∂(uu, vv, uv) [N/m].
template <class Law>
DRAPE_HD StretchStress<Dual<3>> StressByStrain(const Law& law, const GreenStrain<double>& G,
                                               const StretchTable& table) {
  const auto k = EvaluateStretch(law, GreenStrain<Dual<3>>{{G.uu, 0}, {G.vv, 1}, {G.uv, 2}}, table);
  return Stress(k, k.G);
}
// S(G) + ∂S/∂G·rate [N/m]: the stress after a change of strain by `rate`, to first order
// [MODEL, M34].
DRAPE_HD inline StretchStress<double> ExtrapolatedStress(const StretchStress<Dual<3>>& S,
                                                         const GreenStrain<double>& rate) {
  const auto at_rate = [&](const Dual<3>& s) {
    return s.a + s.v[0] * rate.uu + s.v[1] * rate.vv + s.v[2] * rate.uv;
  };
  return {at_rate(S.uu), at_rate(S.vv), at_rate(S.uv)};
}

// The symmetric part of ∂(S.uu, S.vv, S.uv)/∂(uu, vv, 2·uv) [N/m].
struct SymmetricStretch {
  double uu_uu, vv_vv, uv_uv, uu_vv, uu_uv, vv_uv;
};
DRAPE_HD inline SymmetricStretch SymmetricPart(const StretchStress<Dual<3>>& S) {
  return {S.uu.v[0],
          S.vv.v[1],
          0.5 * S.uv.v[2],
          0.5 * (S.uu.v[1] + S.vv.v[0]),
          0.5 * (0.5 * S.uu.v[2] + S.uv.v[0]),
          0.5 * (0.5 * S.vv.v[2] + S.uv.v[1])};
}
// The symmetric part with the stiffnesses held.
DRAPE_HD inline SymmetricStretch HeldStiffness(const StretchCoefficients<double>& k) {
  return {k.c11, k.c22, 0.5 * k.c33, k.c12, 0.0, 0.0};
}

// Rate of the Green strain along w, which is given as columns like F.
template <class T, class W>
DRAPE_HD GreenStrain<T> StrainRate(const DeformationGradient<T>& F,
                                   const DeformationGradient<W>& w) {
  return {Dot(F.u, w.u), Dot(F.v, w.v), 0.5 * (Dot(F.v, w.u) + Dot(F.u, w.v))};
}
// The contribution of ⟨G⟩ to the step matrix: factors of w.u and w.v.
template <class T>
DRAPE_HD StretchStress<T> RampStress(const StretchCoefficients<T>& k) {
  return Stress(k, GreenStrain<T>{k.ramp_uu, k.ramp_vv, T(0.0)});
}

// H·w by rest area, with H the positive approximation of −∂f/∂x [MODEL, M11]: F·S(Ġ) + w·S⟨G⟩.
template <class T, class W>
DRAPE_HD DeformationGradient<T> StretchStiffnessTimes(const StretchCoefficients<T>& k,
                                                      const DeformationGradient<T>& F,
                                                      const DeformationGradient<W>& w) {
  const DeformationGradient<T> FS = F * Stress(k, StrainRate(F, w));
  const StretchStress<T> ramp = RampStress(k);
  return {FS.u + Scale(ramp.uu, w.u), FS.v + Scale(ramp.vv, w.v)};
}

// The stresses of a step: g = h·f − h²·H·w = F·on_F + w·on_w by rest area [MODEL, M31]. The stress
// is linear in the strain, so that one product with F yields both f and H·w. `rate` is the strain
// rate along w.
template <class T>
struct StepStresses {
  StretchStress<T> on_F, on_w;
};
template <class T, class R>
DRAPE_HD StepStresses<T> StretchStepStresses(const StretchCoefficients<T>& k,
                                             const GreenStrain<R>& rate, double h) {
  const double a = -h, b = -h * h;
  const GreenStrain<T> strain{a * k.G.uu + b * rate.uu, a * k.G.vv + b * rate.vv,
                              a * k.G.uv + b * rate.uv};
  const StretchStress<T> ramp = RampStress(k);
  return {Stress(k, strain), {b * ramp.uu, b * ramp.vv, T(0.0)}};
}

// g by rest area, from which everything about a step derives [MODEL, M31].
template <class T>
DRAPE_HD DeformationGradient<T> StretchStepForce(const StretchCoefficients<T>& k,
                                                 const DeformationGradient<T>& F,
                                                 const DeformationGradient<double>& w, double h) {
  const StepStresses<T> S = StretchStepStresses(k, StrainRate(F, w), h);
  const DeformationGradient<T> FS = F * S.on_F;
  return {FS.u + Scale(S.on_w.uu, w.u), FS.v + Scale(S.on_w.vv, w.v)};
}

// ∂g/∂F by rest area with w held [MODEL, M39], shape [6, 6] in the order u.x u.y u.z v.x v.y v.z
// [N·s/m]. It is computed column by column: F changes, and with it the strain and the strain rate
// along w. ∂S/∂G comes from the dual numbers of the law.
template <class Law>
DRAPE_HD void StretchStepDerivative(const Law& law, const DeformationGradient<double>& F,
                                    const StretchTable& table, const DeformationGradient<double>& w,
                                    double h, double out[6][6]) {
  const GreenStrain<double> G = Green(F);
  const auto k = EvaluateStretch(law, GreenStrain<Dual<3>>{{G.uu, 0}, {G.vv, 1}, {G.uv, 2}}, table);
  const StretchCoefficients<double> values = Values(k);
  const StepStresses<Dual<3>> S = StretchStepStresses(k, StrainRate(F, w), h);
  const StretchStress<double> on_F{S.on_F.uu.a, S.on_F.vv.a, S.on_F.uv.a};
  for (int j = 0; j < 6; ++j) {
    DeformationGradient<double> dF{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    (&dF.u.x)[j] = 1.0;
    const GreenStrain<double> dG = StrainRate(F, dF), d_rate = StrainRate(dF, w);
    const auto along = [&](const Dual<3>& s) {
      return s.v[0] * dG.uu + s.v[1] * dG.vv + s.v[2] * dG.uv;
    };
    const StretchStress<double> by_rate = Stress(values, d_rate);
    const StretchStress<double> d_on_F{along(S.on_F.uu) - h * h * by_rate.uu,
                                       along(S.on_F.vv) - h * h * by_rate.vv,
                                       along(S.on_F.uv) - h * h * by_rate.uv};
    const DeformationGradient<double> moved = dF * on_F, strained = F * d_on_F;
    const Vec3<double> u = moved.u + strained.u + along(S.on_w.uu) * w.u;
    const Vec3<double> v = moved.v + strained.v + along(S.on_w.vv) * w.v;
    for (int i = 0; i < 3; ++i) {
      out[i][j] = (&u.x)[i];
      out[3 + i][j] = (&v.x)[i];
    }
  }
}

// The coefficients of a unit stiffness in column m of the table. Force and step matrix are linear
// in them.
DRAPE_HD inline StretchCoefficients<double> UnitStiffness(StretchCoefficients<double> k, int m) {
  k.c11 = m == 0;
  k.c12 = m == 1;
  k.c22 = m == 2;
  k.c33 = m == 3;
  return k;
}

// Adjoint of the step force of one face by rest area, with λ given as columns like F: ∂(g·λ)/∂F
// and, for the table entries, ∂(g·λ)/∂(c11, c12, c22, c33) and the derivatives of these.
struct StretchAdjoint {
  DeformationGradient<double> adj_F;
  double adj_stiffness[kStretchCols];
  double by_entry[kStretchRows][kStretchCols];
  double stiffness_work;  // λ·H·w
};

// g·λ from the strain rates along w and λ and from w·λ of the two columns.
template <class T>
DRAPE_HD T StretchStepWork(const StretchCoefficients<T>& k, const GreenStrain<double>& w_rate,
                           const GreenStrain<double>& lambda_rate, double w_lambda_u,
                           double w_lambda_v, double h) {
  const StepStresses<T> S = StretchStepStresses(k, w_rate, h);
  return S.on_F.uu * lambda_rate.uu + S.on_F.vv * lambda_rate.vv +
         S.on_F.uv * (2.0 * lambda_rate.uv) + S.on_w.uu * w_lambda_u + S.on_w.vv * w_lambda_v;
}

// g·λ depends on F through G and through the two strain rates. It is symmetric in the strain rates,
// and ∂(rate along w)/∂F is w itself.
template <class Law>
DRAPE_HD StretchAdjoint AdjStretchStep(const Law& law, const DeformationGradient<double>& F,
                                       const StretchTable& table,
                                       const DeformationGradient<double>& w, double h,
                                       const DeformationGradient<double>& lambda) {
  const GreenStrain<double> G = Green(F), w_rate = StrainRate(F, w);
  const GreenStrain<double> lambda_rate = StrainRate(F, lambda);
  const double u = Dot(w.u, lambda.u), v = Dot(w.v, lambda.v);
  StretchAdjoint result;
  const auto by_G = EvaluateStretch(law, GreenStrain<Dual<3>>{{G.uu, 0}, {G.vv, 1}, {G.uv, 2}},
                                    table, result.by_entry);
  const Dual<3> work = StretchStepWork(by_G, w_rate, lambda_rate, u, v, h);
  const StretchCoefficients<double> k = Values(by_G);
  const StretchStress<double> ramp = RampStress(k);
  StretchStress<double> by_w_rate = Stress(k, lambda_rate);
  result.stiffness_work = by_w_rate.uu * w_rate.uu + by_w_rate.vv * w_rate.vv +
                          2.0 * by_w_rate.uv * w_rate.uv + ramp.uu * u + ramp.vv * v;
  by_w_rate = {-h * h * by_w_rate.uu, -h * h * by_w_rate.vv, -h * h * by_w_rate.uv};
  const auto by_strain = F * StretchStress<double>{work.v[0], work.v[1], 0.5 * work.v[2]};
  const auto by_w = w * by_w_rate, by_lambda = lambda * StretchStepStresses(k, w_rate, h).on_F;
  result.adj_F = {by_strain.u + by_w.u + by_lambda.u, by_strain.v + by_w.v + by_lambda.v};
  for (int m = 0; m < kStretchCols; ++m)
    result.adj_stiffness[m] = StretchStepWork(UnitStiffness(k, m), w_rate, lambda_rate, u, v, h);
  return result;
}

// Rows of Du and Dv: the derivatives of the columns of F by the position of each corner [1/m].
struct ShapeGradient {
  double u[3], v[3];
};
DRAPE_HD inline ShapeGradient GradientOf(const Face& f) {
  const double* d = f.inverse_rest;
  return {{-d[0] - d[2], d[0], d[2]}, {-d[1] - d[3], d[1], d[3]}};
}

// The contribution of a stress to the stiffness between two corners by rest area: ∫S:∂²G/∂x_a∂x_b =
// weight·I [N/m²]. (ua, va) and (ub, vb) are the rows of Du and Dv of the corners.
DRAPE_HD inline double GeometricWeight(const StretchStress<double>& S, double ua, double va,
                                       double ub, double vb) {
  return ua * (S.uu * ub + S.uv * vb) + va * (S.uv * ub + S.vv * vb);
}

DRAPE_HD inline DeformationGradient<double> GatherColumns(const Face& f, const double* nodes) {
  const Vec3<double> origin = LoadVec3(nodes, f.vertex[0]);
  const Vec3<double> s = LoadVec3(nodes, f.vertex[1]) - origin;
  const Vec3<double> t = LoadVec3(nodes, f.vertex[2]) - origin;
  const double* d = f.inverse_rest;
  return {d[0] * s + d[2] * t, d[1] * s + d[3] * t};
}

// Adds the forces by rest area, times the area, to the nodes: the transpose of GatherColumns.
DRAPE_HD inline void ScatterColumns(const Face& f, const DeformationGradient<double>& by_area,
                                    double* nodes, unsigned corners = ~0U) {
  const ShapeGradient s = GradientOf(f);
  for (int a = 0; a < 3; ++a)
    if ((corners >> a & 1U) != 0)
      AddTo(nodes, f.vertex[a], (f.area * s.u[a]) * by_area.u + (f.area * s.v[a]) * by_area.v);
}

// The strain energy by rest area [N/m] with the stiffnesses held at this strain [MODEL, M12]: a
// true energy for constant tables, otherwise a merit function only, since the stress is in general
// not a gradient.
DRAPE_HD inline double StretchEnergy(const StretchStress<double>& S, const GreenStrain<double>& G) {
  return 0.5 * (S.uu * G.uu + S.vv * G.vv) + S.uv * G.uv;
}

}  // namespace drape
