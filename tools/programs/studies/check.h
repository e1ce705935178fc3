// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "physics/simulation/rollout.h"
#include "physics/util/run_control.h"

namespace drape {

// Checks a user's own scene and material: whether forces, energies and derivatives fit together.

struct CheckRow {
  static constexpr double kNoBound = std::numeric_limits<double>::quiet_NaN();

  std::string group;  // "energy", "stiffness", …
  std::string name;
  double value = 0.0;       // relative errors throughout
  double bound = kNoBound;  // the check holds when value ≤ bound; kNoBound: for information

  bool has_bound() const { return bound == bound; }
  bool ok() const { return !has_bound() || value <= bound; }
};

struct CheckOptions {
  double h = 0.05;      // time step [s]
  int steps = 10;       // of the rollouts, ≥ 1
  int seed = 1;         // of the directions and of the noise
  double noise = 0.02;  // of each coordinate of the start, in mean edge lengths: breaks symmetry
};

// All checks, in the order of a table:
//  forces     sums of internal forces and torques are zero; a rigid motion turns the forces with
//  it;
//             the flat rest carries no load
//  energy     force = −∇energy of bending, gravity and handles. Stretch joins in where every table
//             has equal rows; otherwise its force has no energy (assembly.h) and the row informs.
//             The rise of the total energy informs too: one Newton step a time step promises no
//             decrease
//  stiffness  K = −∂f/∂x against central differences; how unsymmetric K is
//  rollout    tangent = adjoint; both against central differences by the material and by the start.
//             A step whose move an obstacle ends has no derivative, and a row says so instead:
//             shorter steps have one
// Central differences run over steps of 1e-3 … 1e-8 (a row each; mean edge lengths for positions,
// relative for entries), of second and fourth order. Too long a step crosses kinks and sees
// curvature, too short a step drowns in rounding, so the best of the sweep is judged, bound 1e-6.
// Over long rollouts of the reference law even the best step can cross its kinks (100 steps of
// 1,200 vertices: 5e-6).
// material: one table of each kind. A cancelled run ends before the next sweep.
std::vector<CheckRow> CheckScene(std::shared_ptr<const ClothModel> model,
                                 const MaterialField& material, const State& start,
                                 const CheckOptions& options, const RunControl& control = {});

bool AllPass(const std::vector<CheckRow>& rows);

}  // namespace drape
