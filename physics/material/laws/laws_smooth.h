// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"

namespace drape {

// The physics of the reference law without its artefacts [MODEL, M21–M26]: C1 in strain,
// direction and curvature, invariant when the cloth is turned over, and without clamps.

// Weights of the quadratic B-spline over five columns at q ≥ 0 [MODEL, M21], even about column 0.
// Past column 4 the columns are even about it too (`mirror_at_end`, where column 4 is 90°) or
// constant. The columns stay within the table even for NaN, which a diverged shape produces.
template <class T>
DRAPE_HD ColumnWeights<T, 3> SplineWeights(const T& q, bool mirror_at_end) {
  if (!(Value(q) < 4.5)) return {{4, 4, 4}, {T(0.0), T(1.0), T(0.0)}};
  // q ≥ 0 here, and std::lround is not the same on a device.
  const int c = static_cast<int>(Value(q) + 0.5);  // NOLINT(bugprone-incorrect-roundings)
  const T t = q - static_cast<double>(c);
  const T below = 0.5 * (0.5 - t) * (0.5 - t), above = 0.5 * (0.5 + t) * (0.5 + t);
  return {{c == 0 ? 1 : c - 1, c,
           c < 4           ? c + 1
           : mirror_at_end ? 3
                           : 4},
          {below, T(1.0 - below - above), above}};
}

struct SmoothStretch {
  double ramp_width = 3e-4;        // of ⟨G⟩; strains in a drape are about 5e-4 [MODEL, M25]
  double anisotropy_width = 0.02;  // below this principal difference the larger stretch is rounded
  double direction_width = 0.03;   // below this principal difference the direction is undetermined
  double onset_half_width = 0.25;  // rounding of the two corners of the onset, in units of q

  template <class T>
  DRAPE_HD T Ramp(const T& g) const {
    using std::sqrt;
    return 0.5 * (g + sqrt(g * g + ramp_width * ramp_width));
  }

  template <class T>
  DRAPE_HD void Stiffness(const GreenStrain<T>& G, const StretchTable& table,
                          T c[kStretchCols]) const {
    T w[kStretchRows];
    RowWeights(G, w);
    for (int m = 0; m < kStretchCols; ++m) {
      c[m] = w[0] * table.c[0][m];
      for (int r = 1; r < kStretchRows; ++r) c[m] += w[r] * table.c[r][m];
    }
  }
  DRAPE_HD void StiffnessByTable(const GreenStrain<double>& G, const StretchTable&,
                                 double by_entry[kStretchRows][kStretchCols]) const {
    double w[kStretchRows];
    RowWeights(G, w);
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m) by_entry[r][m] = w[r];
  }

 private:
  // Weights over the six rows, factor 2 included [MODEL, M22–M24]: row 0 below the onset, the rows
  // of the principal direction above it.
  template <class T>
  DRAPE_HD void RowWeights(const GreenStrain<T>& G, T w[kStretchRows]) const {
    using std::sqrt;
    const T difference = 2.0 * (G.uu - G.vv), shear = 4.0 * G.uv;
    const T squared = difference * difference + shear * shear;
    const T stretch2 =
        1.0 + G.uu + G.vv +
        0.5 * (sqrt(squared + anisotropy_width * anisotropy_width) - anisotropy_width);
    const T blend = Onset(stretch2);
    w[0] = kMembranePerEntry * (1.0 - blend);
    T by_direction[5];
    DirectionWeights(difference, shear, squared, by_direction);
    for (int i = 0; i < 5; ++i) w[1 + i] = kMembranePerEntry * blend * by_direction[i];
  }

  // A ramp from 0 to 1 while the larger stretch goes from 1 to 7/6 (q = 0..1), with both corners
  // rounded by parabolas [MODEL, M22].
  template <class T>
  DRAPE_HD T Onset(const T& stretch_squared) const {
    using std::sqrt;
    const double d = onset_half_width;
    if (Value(stretch_squared) <= (1.0 - d / 6.0) * (1.0 - d / 6.0)) return T(0.0);
    const T q = 6.0 * (sqrt(stretch_squared) - 1.0);
    const double value = Value(q);
    if (value < d) return (q + d) * (q + d) / (4.0 * d);
    if (value <= 1.0 - d) return q;
    if (value < 1.0 + d) return 1.0 - (1.0 + d - q) * (1.0 + d - q) / (4.0 * d);
    return T(1.0);
  }

  // Weights over the principal directions 0/22.5/45/67.5/90°, or their mean where no direction is
  // preferred [MODEL, M23].
  template <class T>
  DRAPE_HD void DirectionWeights(const T& difference, const T& shear, const T& squared,
                                 T w[5]) const {
    using std::atan2;
    constexpr double kMean[5] = {0.125, 0.25, 0.25, 0.25, 0.125};
    if (Value(squared) < 1e-18) {
      for (int i = 0; i < 5; ++i) w[i] = T(kMean[i]);
      return;
    }
    const T column = atan2(Abs(shear), difference) * (4.0 / M_PI);
    const T known = squared / (squared + direction_width * direction_width);
    for (int i = 0; i < 5; ++i) w[i] = (1.0 - known) * kMean[i];
    const ColumnWeights<T, 3> spline = SplineWeights(column, true);
    for (int i = 0; i < 3; ++i) w[spline.column[i]] += known * spline.weight[i];
  }
};

// The column is 0.4·|α| with α = sin(θ/2)/(h0 + h1) [Gong 2024, eq. 12, 14], [MODEL, M26].
struct SmoothBend {
  static constexpr int kColumns = 3;
  // It bends over the free wing alone [MODEL, M26].
  static constexpr bool kHeldWingBends = false;
  template <class T>
  DRAPE_HD static ColumnWeights<T, kColumns> Columns(const Hinge& hinge, const T& theta) {
    using std::sin;
    return SplineWeights(T(Abs(sin(0.5 * theta)) * ColumnPerSine(hinge)), false);
  }
  // μ = θ + θ³/3 [MODEL, M26].
  DRAPE_HD static HingeMeasure Measure(double theta) {
    const double square = theta * theta;
    return {theta * (1.0 + square / 3.0), 1.0 + square, 2.0 * theta};
  }
  // There is no clamp, since negative entries are rejected when the table is read.
  DRAPE_HD static bool Active(double) { return true; }
  DRAPE_HD static double KnotAngle(const Hinge& hinge, int knot) {
    const double sine = (knot + 0.5) / ColumnPerSine(hinge);
    return sine < 1.0 ? 2.0 * std::asin(sine) : M_PI;
  }

 private:
  // 0.4/(h0 + h1) with h0 + h1 = 2(A0 + A1)/l [MODEL, M26].
  DRAPE_HD static double ColumnPerSine(const Hinge& hinge) {
    return 0.2 * hinge.rest_length / hinge.rest_area;
  }
};

}  // namespace drape
