// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/studies/stability/cases/stability_map.h"

namespace drape {

// The boundary that theory gives for a map of contact, empty where it has none:
// - penalty over time step and speed, plate: the cloth crosses it in one step, v·h = thickness;
// - rod over edge and radius: the middle of an edge reaches the surface, ℓ² = 4Rξ (a sagitta of
//   ℓ²/8R against ξ/2);
// - slope over friction: μ = tan θ;
// - pinch over distance: the layers fill it.
StabilityLine MakeContactLine(const StabilityMap& map);

}  // namespace drape
