// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/simulation/backend.h"

namespace drape {

// L = Σ w·x_end of a rollout by both modes of differentiation, which check one another.
struct RolloutGradient {
  RolloutStatus status = RolloutStatus::kOk;
  double loss = 0.0;        // [m]
  Eigen::VectorXd adjoint;  // ∂L/∂entry, shape [39], the order of MaterialField's tables
  Eigen::VectorXd tangent;  // the same
  Eigen::VectorXd x0, v0;   // ∂L/∂x_start, ∂L/∂v_start, shape [3V]

  double Disagreement() const { return (adjoint - tangent).norm() / tangent.norm(); }
};

// w: shape [3V]; material: one table of each kind.
RolloutGradient DifferentiateRollout(Backend& backend, const MaterialField& material,
                                     const State& start, const RolloutOptions& options,
                                     const Eigen::VectorXd& w);

// Reads {"w": [3V numbers]}. Throws InputError.
Eigen::VectorXd ReadLossWeights(const std::string& path, int num_dofs);

// {"L", "convention": "arcsim", "adjoint" and "tangent": {"stretch" [4][6] (rows c11 c12 c22 c33),
// "bend" [3][5]}, "v0" and "x0" [3V]}; numbers read back bit for bit. Throws InputError.
void WriteLossGradient(const std::string& path, const RolloutGradient& gradient);

}  // namespace drape
