// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/settle.h"

#include <glog/logging.h>

#include <algorithm>
#include <atomic>
#include <utility>

namespace drape {

bool SettledDrape::IsUsable(SolveMode solve_mode) const {
  return steps == RolloutStatus::kOk &&
         (solve_mode == SolveMode::kDynamic || rest.status == EquilibriumStatus::kStable);
}

std::vector<SettledDrape> Settle(Backend& backend, const MaterialField& material,
                                 std::span<const State> starts, const SettleOptions& options) {
  std::vector<RolloutInput> inputs;
  for (const State& start : starts) inputs.push_back({&material, &start});
  return Settle(backend, inputs, options);
}

std::vector<SettledDrape> Settle(Backend& backend, std::span<const RolloutInput> inputs,
                                 const SettleOptions& options) {
  std::vector<RolloutResult> relaxed = backend.Rollouts(inputs, options.steps, nullptr);
  std::vector<RolloutInput> settling;
  for (std::size_t i = 0; i < relaxed.size(); ++i)
    if (relaxed[i].status == RolloutStatus::kOk)
      settling.push_back({inputs[i].material, &relaxed[i].end});
  std::vector<EquilibriumResult> rests;
  if (options.solve_mode == SolveMode::kStatic)
    rests = backend.Equilibria(settling, options.equilibrium);
  std::vector<SettledDrape> drapes(relaxed.size());
  auto rest = rests.begin();
  for (std::size_t i = 0; i < drapes.size(); ++i) {
    drapes[i].steps = relaxed[i].status;
    if (relaxed[i].status != RolloutStatus::kOk) continue;
    if (options.solve_mode == SolveMode::kStatic) {
      drapes[i].rest = std::move(*rest++);
    } else {
      drapes[i].rest.x = std::move(relaxed[i].end.x);
    }
  }
  return drapes;
}

int SettleBatchSize(const Backend& backend, int threads) {
  constexpr int kOnDevices = 64;
  return backend.name() == "cpu" ? threads : std::max(threads, kOnDevices);
}

void SettleInBatches(Backend& backend, int count, int batch,
                     const std::function<DrapeTask(int)>& task, const SettleOptions& options,
                     const std::function<void(int, SettledDrape)>& done) {
  CHECK_GE(batch, 1);
  const std::atomic<bool>* const cancel = options.steps.cancel;
  for (int first = 0; first < count; first += batch) {
    if (cancel != nullptr && *cancel) return;
    std::vector<DrapeTask> tasks;
    for (int i = first; i < std::min(count, first + batch); ++i) tasks.push_back(task(i));
    std::vector<RolloutInput> inputs;
    for (const DrapeTask& each : tasks) inputs.push_back({&each.material, &each.start});
    std::vector<SettledDrape> drapes = Settle(backend, inputs, options);
    if (cancel != nullptr && *cancel) return;
    for (std::size_t i = 0; i < drapes.size(); ++i)
      done(first + static_cast<int>(i), std::move(drapes[i]));
  }
}

}  // namespace drape
