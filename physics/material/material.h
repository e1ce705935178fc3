// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace drape {

// The tables of a fabric. Internally entries follow the convention of ARCSim and of the published
// data, so that they compare digit by digit; files and reports state their convention.
inline constexpr int kStretchRows =
    6;  // row 0: zero strain; 1..5: principal direction 0/22.5/45/67.5/90° at stretch 1/6
inline constexpr int kStretchCols = 4;  // c11 c12 c22 c33
inline constexpr int kBendRows = 3;     // edge direction 0/45/90° to weft
inline constexpr int kBendCols = 5;     // curvature
inline constexpr int kStretchEntries = kStretchRows * kStretchCols;
inline constexpr int kBendEntries = kBendRows * kBendCols;
inline constexpr int kMaterialEntries = kStretchEntries + kBendEntries;  // the "39 numbers"

// Columns of a matrix of 39 tangents, rounded up to whole vector registers.
inline constexpr int kPaddedEntries = (kMaterialEntries + 3) / 4 * 4;

// Membrane stiffness in N/m = kMembranePerEntry × stretch entry [MODEL, M7].
inline constexpr double kMembranePerEntry = 2.0;
// Bend entry B = kBendPerRigidity × plate rigidity D in N·m [MODEL, M8].
inline constexpr double kBendPerRigidity = 4.0;

struct StretchTable {
  double c[kStretchRows][kStretchCols] = {};  // [N/m], shape [6, 4], ARCSim convention
};

struct BendTable {
  double b[kBendRows][kBendCols] = {};  // [N·m], shape [3, 5], B = 4·D
};

// What a rollout needs to know of its fabric: one table for the whole cloth (HOMO) or one for each
// element (HETER, a draw of BDP).
struct MaterialField {
  double density = 0.0;               // [kg/m²]
  std::vector<StretchTable> stretch;  // 1 or F tables
  std::vector<BendTable> bend;        // 1 or E tables (E hinges)

  const StretchTable& stretch_of(int face) const {
    return stretch.size() == 1 ? stretch[0] : stretch[face];
  }
  const BendTable& bend_of(int hinge) const { return bend.size() == 1 ? bend[0] : bend[hinge]; }
};

}  // namespace drape
