// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

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
  RolloutStatus steps = RolloutStatus::kOk;
  // Of Newton, its x the drape; without Newton, or where the steps failed, only x is set: where
  // they ended, or empty.
  EquilibriumResult rest;

  // A drape to go on with: at a stable rest, or the end of the steps where there is no Newton.
  bool Stands(Integrator integrator) const;
};

// In the order of the starts.
std::vector<SettledDrape> Settle(Backend& backend, const MaterialField& material,
                                 std::span<const State> starts, const SettleOptions& options);

}  // namespace drape
