// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/material.h"

namespace drape {

// Quantities of textbooks, expressed in the tables and meshes of this model.

// Poisson ratio of bending by the hinge formula [MODEL, M3] (mesh_rigidity_test).
inline constexpr double kHingePoisson = -1.0 / 3.0;

// A material with one stiffness for all strains and directions: membrane stiffness `k` [N/m]
// without Poisson coupling, plate rigidity `D` [N·m], density [kg/m²].
MaterialField LinearMaterial(double k, double D, double density);

// The load Γ = ρgL³/EI at which the chord of a heavy cantilever (clamped horizontally,
// inextensible) falls `chord` [rad] below the horizontal, 0 < chord < π/2 [MODEL, M53]. It is
// 8.0042 at the 41.5° of [ASTM D1388], where the bending length L/Γ^(1/3) is therefore half the
// overhang. The closed formula (cos(θ/2)/(8·tan θ))^(1/3)·L [Peirce 1930] is 1.9 % larger at 41.5°.
// CHECKs the range.
double HeavyElasticaGamma(double chord);

}  // namespace drape
