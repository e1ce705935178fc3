// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/forward/rollout_gradient.h"

namespace drape {

// Reads {"w": [3V numbers]}. Throws InputError.
Eigen::VectorXd ReadLossWeights(const std::string& path, int num_dofs);

// {"L", "convention": "arcsim", "adjoint" and "tangent": {"stretch" [4][6] (rows c11 c12 c22 c33),
// "bend" [3][5]}, "v0" and "x0" [3V]}; numbers read back bit for bit. Throws InputError.
void WriteLossGradient(const std::string& path, const RolloutGradient& gradient);

}  // namespace drape
