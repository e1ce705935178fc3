// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"

namespace drape {

// Derivatives of the step force g(x; w) of one element (assembly.h) by the entries of its table
// [MODEL, M40].

// g of a face is linear in its four stiffnesses: basis[m] is ∂g/∂(stiffness m), area included, and
// entry (r, m) of `by_entry` is the derivative of stiffness m by entry (r, m) of the table.
struct FaceSensitivity {
  DeformationGradient<double> basis[kStretchCols];
  double by_entry[kStretchRows][kStretchCols];

  // The 24 derivatives of by_entry, row-major.
  DRAPE_INLINE const double* by_entries() const { return &by_entry[0][0]; }
};
template <class Law>
DRAPE_HD FaceSensitivity EvaluateSensitivity(const Law& law, const Face& face,
                                             const StretchTable& table, const double* x,
                                             const double* w, double h) {
  FaceSensitivity s;
  const DeformationGradient<double> F = GatherColumns(face, x), wF = GatherColumns(face, w);
  const StretchCoefficients<double> k = EvaluateStretch(law, Green(F), table, s.by_entry);
  for (int m = 0; m < kStretchCols; ++m) {
    const DeformationGradient<double> g = StretchStepForce(UnitStiffness(k, m), F, wF, h);
    s.basis[m] = {face.area * g.u, face.area * g.v};
  }
  return s;
}

// ∂g/∂entry of a hinge is basis × by_entry: `basis` is minus the step moment of unit κ along ∂θ/∂x,
// and `by_entry` is ∂κ/∂entry.
struct HingeSensitivity {
  HingeGradient basis;
  double by_entry[kBendRows][kBendCols];

  // The 15 derivatives of by_entry, row-major.
  DRAPE_INLINE const double* by_entries() const { return &by_entry[0][0]; }
};
template <class Law>
DRAPE_HD HingeSensitivity EvaluateSensitivity(const Law& law, const Hinge& hinge,
                                              const BendTable& table, const double* x,
                                              const double* w, double h) {
  HingeSensitivity s;
  const HingeCorners corners = GatherCorners(hinge, x);
  const double theta = DihedralAngle(corners);
  s.basis = AngleGradient(EvaluateWings(corners));
  const double q = Dot(s.basis, GatherCorners(hinge, w));
  const double moment = StepMoment(1.0, law.Measure(theta), q, h);
  for (Vec3<double>& d : s.basis.d) d = -moment * d;
  HingeStiffnessByTable(law, hinge, table, law.Columns(hinge, theta), s.by_entry);
  return s;
}

}  // namespace drape
