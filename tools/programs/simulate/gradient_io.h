// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/forward/simulation.h"

namespace drape {

// Reads {"w": [3V numbers]}, x, y and z of vertex 0, then of vertex 1 and so on. Throws InputError.
Eigen::VectorXd ReadLossWeights(const std::string& path, int num_dofs);

// {"format": "drapefit-gradient", "version": 1, "convention": "mechanical", "L" [m], "adjoint" and
// "tangent": {"stretch" [6][4] [m²/N], "bend" [3][5] [1/N]}, "v0" [s] and "x0" [3V]}. Each number
// of the tables is the derivative of L by the number at its place in a mechanical material file
// (WriteMaterial); numbers read back bit for bit. Throws InputError.
void WriteLossGradient(const std::string& path, const RolloutGradient& gradient);

}  // namespace drape
