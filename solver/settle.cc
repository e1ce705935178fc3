// SPDX-License-Identifier: Apache-2.0
#include "solver/settle.h"

#include <utility>

namespace drape {

SettledDrape Settle(Backend& backend, const MaterialField& material, const State& start,
                    const SettleOptions& options) {
  SettledDrape drape;
  RolloutInput input{&material, &start};
  RolloutResult fallen = std::move(backend.Rollouts({&input, 1}, options.steps, nullptr).front());
  drape.steps = fallen.status;
  if (fallen.status != RolloutStatus::kOk) return drape;
  if (options.integrator == Integrator::kDynamic) {
    drape.x = std::move(fallen.end.x);
    return drape;
  }
  input.start = &fallen.end;
  drape.rest = std::move(backend.Equilibria({&input, 1}, options.equilibrium).front());
  if (drape.rest.status == EquilibriumStatus::kStable) drape.x = std::move(drape.rest.x);
  return drape;
}

}  // namespace drape
