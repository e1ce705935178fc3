// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "physics/material/laws/bend_element.h"
#include "physics/material/laws/stretch_element.h"

namespace drape {

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

  // The four stiffnesses at a strain [N/m], interpolated trilinearly between clamped nodes
  // [MODEL, M17].
  template <class T>
  DRAPE_HD void Stiffness(const GreenStrain<T>& G, const StretchTable& table,
                          T c[kStretchCols]) const {
    for (int m = 0; m < kStretchCols; ++m) c[m] = T(0.0);
    ForEachNode(G, [&](const StretchNode& node, const T& weight) {
      for (int m = 0; m < kStretchCols; ++m) {
        const double value = node.Sample(table, m);
        if (value > 0.0) c[m] += weight * value;
      }
    });
  }

  // ∂(stiffness m)/∂(entry r, m), shape [6, 4]. Nodes that are clamped at zero contribute nothing
  // [MODEL, M17].
  DRAPE_HD void StiffnessByTable(const GreenStrain<double>& G, const StretchTable& table,
                                 double by_entry[kStretchRows][kStretchCols]) const {
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m) by_entry[r][m] = 0.0;
    ForEachNode(G, [&](const StretchNode& node, double weight) {
      for (int m = 0; m < kStretchCols; ++m) {
        if (!(node.Sample(table, m) > 0.0)) continue;
        by_entry[0][m] += kMembranePerEntry * weight * (1.0 - node.blend);
        by_entry[node.row][m] += kMembranePerEntry * weight * node.blend * (1.0 - node.fraction);
        by_entry[node.row + 1][m] += kMembranePerEntry * weight * node.blend * node.fraction;
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
};

}  // namespace drape
