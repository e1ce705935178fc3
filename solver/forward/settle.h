// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "physics/simulation/backend.h"
#include "solver/forward/solve_mode.h"

namespace drape {

// How a drape grows from a start shape: time steps calm it, then Newton takes it to rest.
struct SettleOptions {
  RolloutOptions steps = {};
  SolveMode integrator = SolveMode::kStatic;  // kDynamic: without Newton
  EquilibriumOptions equilibrium = {};
};

struct SettledDrape {
  RolloutStatus steps = RolloutStatus::kOk;
  // Of Newton, its x the drape; without Newton, or where the steps failed, only x is set: where
  // they ended, or empty.
  EquilibriumResult rest;

  // A drape to go on with: at a stable rest, or the end of the steps where there is no Newton.
  bool IsUsable(SolveMode integrator) const;
};

// In the order of the starts.
std::vector<SettledDrape> Settle(Backend& backend, const MaterialField& material,
                                 std::span<const State> starts, const SettleOptions& options);
// Of several materials, in the order of the inputs.
std::vector<SettledDrape> Settle(Backend& backend, std::span<const RolloutInput> inputs,
                                 const SettleOptions& options);

// A drape to settle.
struct DrapeTask {
  MaterialField material;
  State start;
};

// Starts at a time that keep a backend busy: few keep a device waiting for the host.
int SettleBatchSize(const Backend& backend, int threads);

// Settles the tasks 0 … count − 1, `batch` of them at a time, each made when its turn comes, and
// hands the drapes over in order. Which are settled together changes no bit of them (Backend). When
// *options.steps.cancel turns true it ends, and what was under way is not handed over.
void SettleInBatches(Backend& backend, int count, int batch,
                     const std::function<DrapeTask(int)>& task, const SettleOptions& options,
                     const std::function<void(int, SettledDrape)>& done);

}  // namespace drape
