// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/dual.h"
#include "physics/material.h"
#include "physics/mesh.h"
#include "physics/vec3.h"

namespace drape {

// One triangle as a function of its deformation gradient (SPEC section 3, facts 4 and 5).
// F = [xu xv] are its columns; shape [3, 2], no unit.
template <class T>
struct DeformationGradient {
  Vec3<T> u, v;
};

// Green strain G = ½(FᵀF − I), no unit.
template <class T>
struct GreenStrain {
  T uu, vv, uv;
};

template <class T>
DRAPE_HD GreenStrain<T> Green(const DeformationGradient<T>& F) {
  return {0.5 * (Dot(F.u, F.u) - 1.0), 0.5 * (Dot(F.v, F.v) - 1.0), 0.5 * Dot(F.u, F.v)};
}

// The four stiffnesses at a strain [N/m] and the ramped strains ⟨G⟩ that the step matrix uses.
template <class T>
struct StretchCoefficients {
  T c11, c12, c22, c33;
  GreenStrain<T> G;
  T ramp_uu, ramp_vv;
};

template <class Law, class T>
DRAPE_HD StretchCoefficients<T> EvaluateStretch(const Law& law, const DeformationGradient<T>& F,
                                                const StretchTable& table) {
  StretchCoefficients<T> k;
  k.G = Green(F);
  T c[kStretchCols];
  law.Stiffness(k.G, table, c);
  k.c11 = c[0];
  k.c12 = c[1];
  k.c22 = c[2];
  k.c33 = c[3];
  k.ramp_uu = law.Ramp(k.G.uu);
  k.ramp_vv = law.Ramp(k.G.vv);
  return k;
}

// Force by rest area, as the two columns that Du, Dv carry to the vertices (fact 4) [N/m].
template <class T>
DRAPE_HD DeformationGradient<T> StretchForce(const StretchCoefficients<T>& k,
                                             const DeformationGradient<T>& F) {
  const T su = -(k.c11 * k.G.uu + k.c12 * k.G.vv), sv = -(k.c22 * k.G.vv + k.c12 * k.G.uu);
  const T suv = -(k.c33 * k.G.uv);
  return {su * F.u + suv * F.v, sv * F.v + suv * F.u};
}

// H·w by rest area, H = the positive approximation of −∂f/∂x (fact 5), w as columns like F.
template <class T, class W>
DRAPE_HD DeformationGradient<T> StretchStiffnessTimes(const StretchCoefficients<T>& k,
                                                      const DeformationGradient<T>& F,
                                                      const DeformationGradient<W>& w) {
  const T du = Dot(F.u, w.u), dv = Dot(F.v, w.v), duv = Dot(F.v, w.u) + Dot(F.u, w.v);
  const T su = k.c11 * du + k.c12 * dv, sv = k.c22 * dv + k.c12 * du, suv = 0.5 * k.c33 * duv;
  const T ru = k.c11 * k.ramp_uu + k.c12 * k.ramp_vv, rv = k.c22 * k.ramp_vv + k.c12 * k.ramp_uu;
  return {su * F.u + suv * F.v + Scale(ru, w.u), sv * F.v + suv * F.u + Scale(rv, w.v)};
}

// g = h·f − h²·H·w by rest area (SPEC section 4): everything about a step derives from it.
template <class T>
DRAPE_HD DeformationGradient<T> StretchStepForce(const StretchCoefficients<T>& k,
                                                 const DeformationGradient<T>& F,
                                                 const DeformationGradient<double>& w, double h) {
  const DeformationGradient<T> f = StretchForce(k, F), Hw = StretchStiffnessTimes(k, F, w);
  return {h * f.u - h * h * Hw.u, h * f.v - h * h * Hw.v};
}

// The coefficients of a unit stiffness in column m of the table: force and matrix are linear in them.
DRAPE_HD inline StretchCoefficients<double> UnitStiffness(StretchCoefficients<double> k, int m) {
  k.c11 = m == 0;
  k.c12 = m == 1;
  k.c22 = m == 2;
  k.c33 = m == 3;
  return k;
}

// Rows of Du and Dv: how vertex `corner` moves the columns of F [1/m].
struct ShapeGradient {
  double u[3], v[3];
};
DRAPE_HD inline ShapeGradient GradientOf(const Face& f) {
  const double* d = f.inverse_rest;
  return {{-d[0] - d[2], d[0], d[2]}, {-d[1] - d[3], d[1], d[3]}};
}

DRAPE_HD inline DeformationGradient<double> GatherColumns(const Face& f, const double* nodes) {
  const Vec3<double> origin = LoadVec3(nodes, f.vertex[0]);
  const Vec3<double> s = LoadVec3(nodes, f.vertex[1]) - origin;
  const Vec3<double> t = LoadVec3(nodes, f.vertex[2]) - origin;
  const double* d = f.inverse_rest;
  return {d[0] * s + d[2] * t, d[1] * s + d[3] * t};
}

// Strain energy by rest area [N/m] with the stiffnesses held at this strain: a true energy for
// constant tables, a merit function otherwise (C(λ,φ)ε is in general no gradient).
DRAPE_HD inline double StretchEnergy(const StretchCoefficients<double>& k) {
  return 0.5 * (k.c11 * k.G.uu * k.G.uu + k.c22 * k.G.vv * k.G.vv) + k.c12 * k.G.uu * k.G.vv +
         k.c33 * k.G.uv * k.G.uv;
}

}  // namespace drape
