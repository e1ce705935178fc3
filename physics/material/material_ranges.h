// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/material_io.h"

namespace drape {

class JsonInput;

// Internal to physics/material: what files of materials may hold. In the mechanical convention:
// that of fabrics, with a factor of at least 1e3 to spare.
inline constexpr double kMinDensity = 1e-5, kMaxDensity = 1e3;  // [kg/m²]
inline constexpr double kMaxMembraneStiffness = 1e8;            // [N/m]
inline constexpr double kMaxRigidity = 100.0;                   // [N·m]

// The numbers at these places of a file; `most`: the largest size of an entry there, in its unit.
// Throw InputError.
double ReadDensity(const JsonInput& input);
double ReadEntry(const JsonInput& input, double most, const MaterialPolicy& policy);

}  // namespace drape
