// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>
#include <variant>

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

  // by_entry: ∂(stiffness m)/∂(entry r, m), or null.
  template <class T>
  DRAPE_HD void Stiffness(const GreenStrain<T>& G, const StretchTable& table, T c[kStretchCols],
                          double (*by_entry)[kStretchCols] = nullptr) const {
    T w[kStretchRows];
    RowWeights(G, w);
    for (int m = 0; m < kStretchCols; ++m) {
      c[m] = w[0] * table.c[0][m];
      for (int r = 1; r < kStretchRows; ++r) c[m] += w[r] * table.c[r][m];
    }
    if (by_entry == nullptr) return;
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m) by_entry[r][m] = Value(w[r]);
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
    return 2.0 * std::asin((knot + 0.5) / ColumnPerSine(hinge));
  }
  DRAPE_HD static int CountKnots(const Hinge& hinge, double theta) {
    const double column = std::sin(0.5 * theta) * ColumnPerSine(hinge);
    if (!(column < kBendCols - 0.5)) return kBendCols;
    return static_cast<int>(column + 0.5);  // NOLINT(bugprone-incorrect-roundings): as above
  }

 private:
  // 0.4/(h0 + h1) with h0 + h1 = 2(A0 + A1)/l [MODEL, M26].
  DRAPE_HD static double ColumnPerSine(const Hinge& hinge) {
    return 0.2 * hinge.rest_length / hinge.rest_area;
  }
};

// The law of the public reference simulator, reproduced to rounding [MODEL, M16–M19], including its
// strain grid, kinks and clamps.

// Weights of one node of the 10³ strain grid over the rows of a stretch table, without the factor 2
// and the clamp at zero [MODEL, M16].
struct StretchNode {
  int row;          // rows `row` and row + 1 (1..5) contribute beside row 0
  double blend;     // weight of rows ≥ 1 against row 0
  double fraction;  // of row + 1

  DRAPE_HD double Sample(const StretchTable& table, int m) const {
    const double strained = (1.0 - fraction) * table.c[row][m] + fraction * table.c[row + 1][m];
    return kMembranePerEntry * ((1.0 - blend) * table.c[0][m] + blend * strained);
  }
};

inline constexpr int kStrainNodes = 10;  // nodes along each axis

// Node (i, j, k) of the strain grid [MODEL, M16].
inline StretchNode MakeStretchNode(int i, int j, int k) {
  const double a = 0.5 + 0.2 * i, b = 0.5 + 0.2 * j, c = 0.2 * k;
  const double w = 0.5 * (a + b + std::sqrt(4.0 * c * c + (a - b) * (a - b)));
  const double angle = k == 0 ? (i >= j ? 0.0 : M_PI / 2) : std::fabs(std::atan2(c, w - b));
  const double column = std::fmin(std::fmax(8.0 * angle / M_PI, 0.0), 4.0);
  const int row = column < 3.0 ? static_cast<int>(column) : 3;
  const double blend = std::fmin(std::fmax(6.0 * (std::sqrt(w) - 1.0), 0.0), 1.0);
  return {1 + row, blend, column - row};
}

class ReferenceStretch {
 public:
  // nodes: [10, 10, 10]; the device passes its own copy.
  DRAPE_HD explicit ReferenceStretch(const StretchNode* nodes) : nodes_(nodes) {}
  ReferenceStretch();  // the host's table

  const StretchNode* nodes() const { return nodes_; }

  template <class T>
  DRAPE_HD static T Ramp(const T& g) {
    return Value(g) > 0.0 ? g : T(0.0);
  }

  // The four stiffnesses at a strain [N/m], interpolated trilinearly between clamped nodes, and
  // ∂(stiffness m)/∂(entry r, m) unless by_entry is null. Nodes that are clamped at zero contribute
  // nothing [MODEL, M17].
  template <class T>
  DRAPE_HD void Stiffness(const GreenStrain<T>& G, const StretchTable& table, T c[kStretchCols],
                          double (*by_entry)[kStretchCols] = nullptr) const {
    for (int m = 0; m < kStretchCols; ++m) {
      c[m] = T(0.0);
      for (int r = 0; by_entry != nullptr && r < kStretchRows; ++r) by_entry[r][m] = 0.0;
    }
    ForEachNode(G, [&](const StretchNode& node, const T& weight) {
      for (int m = 0; m < kStretchCols; ++m) {
        const double value = node.Sample(table, m);
        if (!(value > 0.0)) continue;
        c[m] += weight * value;
        if (by_entry == nullptr) continue;
        const double share = kMembranePerEntry * Value(weight);
        by_entry[0][m] += share * (1.0 - node.blend);
        by_entry[node.row][m] += share * node.blend * (1.0 - node.fraction);
        by_entry[node.row + 1][m] += share * node.blend * node.fraction;
      }
    });
  }

 private:
  template <class T>
  struct Axis {
    int cell;
    T weight[2];
  };
  template <class T>
  DRAPE_HD static Axis<T> Locate(const T& coordinate) {
    const double value = Value(coordinate);
    if (!(value > 0.0)) return {0, {T(1.0), T(0.0)}};
    if (value >= kStrainNodes - 1) return {kStrainNodes - 2, {T(0.0), T(1.0)}};
    const int cell = static_cast<int>(value);
    const T t = coordinate - static_cast<double>(cell);
    return {cell, {T(1.0 - t), t}};
  }
  template <class T, class Visit>
  DRAPE_HD void ForEachNode(const GreenStrain<T>& G, Visit visit) const {
    const Axis<T> i = Locate(T((G.uu + 0.25) * 10.0)), j = Locate(T((G.vv + 0.25) * 10.0));
    const Axis<T> k = Locate(T(Abs(G.uv) * 10.0));
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) {
        const T ab = i.weight[a] * j.weight[b];
        const StretchNode* row = nodes_ + ((i.cell + a) * kStrainNodes + j.cell + b) * kStrainNodes;
        for (int d = 0; d < 2; ++d) visit(row[k.cell + d], ab * k.weight[d]);
      }
  }

  const StretchNode* nodes_;
};

// The column is linear in the signed curvature, so that every ridge lies in column 0 [MODEL, M19].
struct ReferenceBend {
  static constexpr int kColumns = 2;
  // A hinge on the border of what is held bends over both wings, as inside the cloth.
  static constexpr bool kHeldWingBends = true;
  template <class T>
  DRAPE_HD static ColumnWeights<T, kColumns> Columns(const Hinge& hinge, const T& theta) {
    const T column = theta * (0.1 * hinge.rest_length / hinge.rest_area);
    const double value = Value(column);
    if (!(value > 0.0)) return {{0, 1}, {T(1.0), T(0.0)}};
    if (value >= kBendCols - 1) return {{kBendCols - 2, kBendCols - 1}, {T(0.0), T(1.0)}};
    const int c = static_cast<int>(value);
    const T t = column - static_cast<double>(c);
    return {{c, c + 1}, {T(1.0 - t), t}};
  }
  // The angle itself [MODEL, M13].
  DRAPE_HD static HingeMeasure Measure(double theta) { return {theta, 1.0, 0.0}; }
  // False where the interpolated entry is clamped at zero.
  DRAPE_HD static bool Active(double B) { return B > 0.0; }
  // The angle at the end of smooth piece `knot` = 0..4 [rad].
  DRAPE_HD static double KnotAngle(const Hinge& hinge, int knot) {
    return knot * hinge.rest_area / (0.1 * hinge.rest_length);
  }
  // The number of knots below an angle θ ≥ 0.
  DRAPE_HD static int CountKnots(const Hinge& hinge, double theta) {
    const double column = theta * (0.1 * hinge.rest_length / hinge.rest_area);
    return column < kBendCols - 1 ? 1 + static_cast<int>(column) : kBendCols;
  }
};

// How stiffness depends on strain and on curvature: two independent choices.
struct Law {
  std::variant<SmoothStretch, ReferenceStretch> stretch;
  std::variant<SmoothBend, ReferenceBend> bend;

  bool rejects_negative_entries() const {
    return std::holds_alternative<SmoothStretch>(stretch) ||
           std::holds_alternative<SmoothBend>(bend);
  }
  bool held_wing_bends() const {
    return std::visit([](const auto& law) { return law.kHeldWingBends; }, bend);
  }
};

// Makes the law of that name, "reference" or "smooth" (both parts). Throws InputError for any other
// name.
Law MakeLaw(const std::string& name);

// Not from material_io.h, which takes C++20: kernels include this header in C++17.
struct MaterialPolicy;
// How the fabrics of a law are read: the reference law takes negative entries.
MaterialPolicy ReadingPolicy(const Law& law, double min_relative_stiffness = 0.0);

}  // namespace drape
