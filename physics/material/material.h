// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/util/math/host_device.h"

namespace drape {

// The tables of a fabric [MODEL, M7, M8]. Inside the program, entries follow the convention of
// ARCSim and of the published data, so that they can be compared digit by digit; files and reports
// state their convention [MODEL, M9].
inline constexpr int kStretchRows =
    6;  // row 0: zero strain; 1..5: principal direction 0/22.5/45/67.5/90° at stretch 1/6
inline constexpr int kStretchCols = 4;  // c11 c12 c22 c33
inline constexpr int kBendRows = 3;     // edge direction 0/45/90° to weft
inline constexpr int kBendCols = 5;     // curvature
inline constexpr int kStretchEntries = kStretchRows * kStretchCols;
inline constexpr int kBendEntries = kBendRows * kBendCols;
inline constexpr int kMaterialEntries = kStretchEntries + kBendEntries;  // 39

// Columns of a matrix with one column for each entry, rounded up to whole vector registers.
inline constexpr int kPaddedEntries = (kMaterialEntries + 3) / 4 * 4;

// Membrane stiffness in N/m = kMembranePerEntry × stretch entry [MODEL, M7].
inline constexpr double kMembranePerEntry = 2.0;
// Bend entry B = kBendPerRigidity × plate rigidity D in N·m [MODEL, M8].
inline constexpr double kBendPerRigidity = 4.0;

struct StretchTable {
  double c[kStretchRows][kStretchCols] = {};  // [N/m], shape [6, 4], ARCSim convention

  // The 24 entries, row-major.
  DRAPE_INLINE double* entries() { return &c[0][0]; }
  DRAPE_INLINE const double* entries() const { return &c[0][0]; }
};

struct BendTable {
  double b[kBendRows][kBendCols] = {};  // [N·m], shape [3, 5], B = 4·D

  // The 15 entries, row-major.
  DRAPE_INLINE double* entries() { return &b[0][0]; }
  DRAPE_INLINE const double* entries() const { return &b[0][0]; }
};

// What acts on a cloth only while it moves, in linearly implicit time steps [MODEL, M64, M65].
// Where all is zero nothing acts, and a step has the bits that it has without.
struct Dynamics {
  double mass_damping = 0.0;            // α of the damping force −αM·v [1/s]
  double stiffness_damping = 0.0;       // β of the damping force −βH·v, H of the elements [s]
  double air_drag = 0.0;                // half of the density of air × drag coefficient [kg/m³]
  Vec3<double> wind = {0.0, 0.0, 0.0};  // velocity of the air [m/s]

  bool Acts() const { return mass_damping != 0.0 || stiffness_damping != 0.0 || air_drag != 0.0; }
};

// The fabric as a rollout uses it: one table for the whole cloth (homogeneous) or one for each
// element (heterogeneous, or a sample of a hierarchical model).
struct MaterialField {
  double density = 0.0;               // [kg/m²]
  std::vector<StretchTable> stretch;  // 1 or F tables
  std::vector<BendTable> bend;        // 1 or E tables (E hinges)
  Dynamics dynamics = {};

  const StretchTable& stretch_of(int face) const {
    return stretch.size() == 1 ? stretch[0] : stretch[face];
  }
  const BendTable& bend_of(int hinge) const { return bend.size() == 1 ? bend[0] : bend[hinge]; }
};

}  // namespace drape
