// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/rollouts/rollout_engine.h"

#include <algorithm>
#include <utility>

#include "cuda/kernels/contact_kernels.h"

namespace drape {

void RolloutEngine::Rollouts(std::span<const RolloutInput> batch, const RolloutOptions& options,
                             std::span<Recording> recordings, std::span<RolloutResult> results,
                             std::span<char> failed) {
  const DeviceCloth& cloth = resources_.cloth();
  const bool record = !recordings.empty();
  const HistoryChoice choice =
      record ? ChooseHistory(resources_, batch.size(), options.steps) : HistoryChoice();
  const std::size_t history = (record ? HistoryBytes(cloth, options.steps) : 0) +
                              (choice.with_factors ? FactorBytes(cloth, options.steps) : 0);
  std::vector<RolloutResult*> ends;
  for (RolloutResult& result : results) ends.push_back(&result);
  resources_.ForEachChunk(
      batch.size(), [&](Arena& arena, int slots) { StepWorkspace::Take(arena, cloth, slots); },
      history,
      [&](std::size_t first, std::size_t count) {
        const auto chunk = batch.subspan(first, count);
        const RolloutRun run = RunRollouts(chunk, options, choice, record);
        CollectEnds(run.workspace, run.steps, options.steps, std::span(ends).subspan(first, count),
                    failed.subspan(first, count));
        if (!record) return;
        const auto kept = recordings.subspan(first, count);
        if (!choice.on_device)
          return DownloadRecordings(cloth, *run.history, chunk, run.steps, kept);
        std::ranges::move(MakeRecordings(run.history, run.steps), kept.begin());
      });
}

RolloutRun RolloutEngine::RunRollouts(std::span<const RolloutInput> batch,
                                      const RolloutOptions& options, HistoryChoice choice,
                                      bool record) {
  const DeviceCloth& cloth = resources_.cloth();
  const int slots = static_cast<int>(batch.size()), dofs = cloth.view().num_dofs();
  StepWorkspace w{};
  resources_.Allocate(slots,
                      [&](Arena& arena, int n) { w = StepWorkspace::Take(arena, cloth, n); });
  auto history = std::make_shared<DeviceHistory>();
  history->device = resources_.device().index;
  history->slots = slots;
  HistoryView kept{nullptr, nullptr, static_cast<std::int64_t>(slots) * dofs, w.step};
  if (record) {
    history->x = DeviceBuffer<double>(static_cast<std::size_t>(options.steps) * slots * dofs);
    history->v = DeviceBuffer<double>(history->x.size());
    if (choice.with_factors) {
      const std::int64_t stride = slots * cloth.multifrontal().view().factor_size;
      history->factor = DeviceBuffer<double>(static_cast<std::size_t>(options.steps) * stride);
      w.factor = {history->factor.data(), w.step, stride};
    }
    kept.x = history->x.data();
    kept.v = history->v.data();
  }
  const DeviceMaterials materials(CollectMaterials(batch));
  resources_.UploadStarts(batch, w.x, w.v);
  resources_.Clear(w.failed, slots * sizeof(int));
  resources_.Clear(w.step, sizeof(int));
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.x};
  LaunchPushOut(resources_.On(shapes), w.x);
  // A recording is for derivatives, which a shortened move has not.
  const BlockedMove blocked = record ? BlockedMove::kFails : BlockedMove::kEnds;
  const Streams& streams = resources_.streams();
  const Graph step(streams, [&] {
    streams.ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      const LaunchContext on = resources_.On(SliceBatch(shapes, first, count, dofs), stream);
      LaunchSolveStep(on, cloth.multifrontal(), w, first, options.h);
      LaunchAdvanceGroup(on, w, first, options.h, blocked, kept);
    });
    LaunchCountStep(w.step, 1, streams.main());
  });
  const int done = resources_.RunSteps(step, options.steps, options.cancel);
  streams.Synchronize();
  return {w, history, done};
}

void RolloutEngine::CollectEnds(const StepWorkspace& w, int steps, int wanted_steps,
                                std::span<RolloutResult* const> results,
                                std::span<char> failed) const {
  resources_.DownloadEnds(w.x, w.v, results);
  std::vector<int> flags(results.size());
  CopyToHost<int>(w.failed, flags);
  for (std::size_t i = 0; i < results.size(); ++i) {
    failed[i] = flags[i] != 0;
    RolloutResult& result = *results[i];
    result.status = steps < wanted_steps ? RolloutStatus::kCancelled : RolloutStatus::kOk;
    result.steps = steps;
  }
}

}  // namespace drape
