// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/settle.h"

#include <glog/logging.h>

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/state.h"

namespace drape {

bool SettledDrape::IsUsable(SolveMode solve_mode) const {
  return steps == RolloutStatus::kOk &&
         (solve_mode == SolveMode::kDynamic || rest.status == EquilibriumStatus::kStable);
}

std::vector<RolloutInput> MakeInputs(const MaterialField& material, std::span<const State> starts) {
  std::vector<RolloutInput> inputs;
  for (const State& start : starts) inputs.push_back({&material, &start});
  return inputs;
}

std::vector<SettledDrape> Settle(Backend& backend, const MaterialField& material,
                                 std::span<const State> starts, const SettleOptions& options) {
  return Settle(backend, MakeInputs(material, starts), options);
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

namespace {

double LargestDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {  // of a vertex [m]
  return (a - b).reshaped(3, a.size() / 3).colwise().norm().maxCoeff();
}

// The end of 30 s of time steps from x, which is x itself where a step fails.
NudgedDrape Release(Backend& backend, const MaterialField& material, const Eigen::VectorXd& x,
                    const std::atomic<bool>* cancel) {
  const State start{x, Eigen::VectorXd::Zero(x.size())};
  const RolloutInput input{&material, &start};
  const RolloutOptions steps{.h = 0.1, .steps = 300, .cancel = cancel};
  RolloutResult end = backend.Rollouts({&input, 1}, steps, nullptr).front();
  if (end.status != RolloutStatus::kOk) return {.status = EquilibriumStatus::kNotConverged, .x = x};
  const double drift = LargestDistance(end.end.x, x);
  return {.x = std::move(end.end.x), .drift = drift};
}

NudgedDrape NudgeHem(Backend& backend, const MaterialField& material, const Eigen::VectorXd& x,
                     const EquilibriumOptions& options) {
  constexpr int kNudges = 4;
  constexpr double kNudge = 1e-4;  // rms [m]
  const Mesh& mesh = backend.model().mesh;
  const std::optional<double> support = SupportRadius(backend.model().scene);
  CHECK(support.has_value());
  std::vector<State> nudged;
  for (int seed = 1; seed <= kNudges; ++seed) {
    const StartShape waves = RandomStartShape(seed, kNudge);
    const Eigen::VectorXd moved = x + ApplyStartShape(mesh, *support, waves) - mesh.rest_x;
    nudged.push_back({ReachSafely(backend.model(), x, moved), Eigen::VectorXd::Zero(x.size())});
  }
  NudgedDrape furthest{.x = x};
  for (EquilibriumResult& end : backend.Equilibria(MakeInputs(material, nudged), options)) {
    if (end.status != EquilibriumStatus::kStable) return {.status = end.status, .x = x};
    const double drift = LargestDistance(end.x, x);
    if (drift >= furthest.drift) furthest = {.x = std::move(end.x), .drift = drift};
  }
  return furthest;
}

bool IsKept(const NudgedDrape& drape) {
  return drape.status == EquilibriumStatus::kStable && drape.drift <= kAtRestDrift;
}

}  // namespace

NudgedDrape Nudge(Backend& backend, const MaterialField& material, const Eigen::VectorXd& x,
                  const EquilibriumOptions& options) {
  NudgedDrape nudged = NudgeHem(backend, material, x, options);
  if (IsKept(nudged)) return nudged;
  NudgedDrape released = Release(backend, material, x, options.cancel);
  return IsKept(released) ? released : nudged;
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
