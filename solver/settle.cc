// SPDX-License-Identifier: Apache-2.0
#include "solver/settle.h"

#include <utility>

namespace drape {

bool SettledDrape::Stands(Integrator integrator) const {
  return steps == RolloutStatus::kOk &&
         (integrator == Integrator::kDynamic || rest.status == EquilibriumStatus::kStable);
}

std::vector<SettledDrape> Settle(Backend& backend, const MaterialField& material,
                                 std::span<const State> starts, const SettleOptions& options) {
  std::vector<RolloutInput> inputs, calm;
  for (const State& start : starts) inputs.push_back({&material, &start});
  std::vector<RolloutResult> fallen = backend.Rollouts(inputs, options.steps, nullptr);
  for (const RolloutResult& result : fallen)
    if (result.status == RolloutStatus::kOk) calm.push_back({&material, &result.end});
  std::vector<EquilibriumResult> rests;
  if (options.integrator == Integrator::kStatic)
    rests = backend.Equilibria(calm, options.equilibrium);
  std::vector<SettledDrape> drapes(fallen.size());
  auto rest = rests.begin();
  for (std::size_t i = 0; i < drapes.size(); ++i) {
    drapes[i].steps = fallen[i].status;
    if (fallen[i].status != RolloutStatus::kOk) continue;
    if (options.integrator == Integrator::kStatic) {
      drapes[i].rest = std::move(*rest++);
    } else {
      drapes[i].rest.x = std::move(fallen[i].end.x);
    }
  }
  return drapes;
}

}  // namespace drape
