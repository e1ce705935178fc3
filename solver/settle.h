// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/backend.h"
#include "solver/rollout_batch.h"

namespace drape {

// How a drape grows from a start shape: time steps calm it, then Newton takes it to rest.
struct SettleOptions {
  RolloutOptions steps;
  Integrator integrator = Integrator::kStatic;  // kDynamic: without Newton
  EquilibriumOptions equilibrium;
};

struct SettledDrape {
  Eigen::VectorXd x;  // [m], shape [3V]; empty when it failed or, with Newton, is not stable
  RolloutStatus steps = RolloutStatus::kOk;
  EquilibriumResult rest;  // of Newton, its x moved away
};

SettledDrape Settle(Backend& backend, const MaterialField& material, const State& start,
                    const SettleOptions& options);

}  // namespace drape
