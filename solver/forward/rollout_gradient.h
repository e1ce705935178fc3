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

}  // namespace drape
