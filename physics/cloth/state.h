// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace drape {

// Positions [m] and velocities [m/s] of a cloth, node-major, shape [3V] each.
struct State {
  Eigen::VectorXd x;
  Eigen::VectorXd v;
};

}  // namespace drape
