// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "cuda/engine/adjoint_workspace.h"

namespace drape {
namespace {

// A recording in the host's form, of a history on the device.
void Download(const DeviceCloth& cloth, const DeviceHistory& history,
              std::span<const RolloutInput> batch, int steps, std::span<Recording> recordings) {
  const int dofs = cloth.view().num_dofs();
  std::vector<double> x(history.x.size()), v(x.size());
  CopyToHost<double>(history.x.data(), x);
  CopyToHost<double>(history.v.data(), v);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    recordings[i].x.assign(steps, Eigen::VectorXd(dofs));
    recordings[i].v.assign(1, batch[i].start->v);
    recordings[i].v.resize(steps + 1, Eigen::VectorXd(dofs));
    recordings[i].factor.assign(steps, {});
    for (int k = 0; k < steps; ++k) {
      const std::size_t at = (static_cast<std::size_t>(k) * history.slots + i) * dofs;
      cloth.ToMeshOrder(x.data() + at, 1, 1, recordings[i].x[k].data());
      cloth.ToMeshOrder(v.data() + at, 1, 1, recordings[i].v[k + 1].data());
    }
  }
}

}  // namespace

void DeviceEngine::Rollouts(std::span<const RolloutInput> batch, const RolloutOptions& options,
                            std::span<Recording> recordings, std::span<RolloutResult> results,
                            std::span<char> failed) {
  Bind();
  const auto take = [&](Arena& arena, int slots) { StepWorkspace::Take(arena, *cloth_, slots); };
  const HistoryChoice choice =
      recordings.empty() ? HistoryChoice() : ChooseHistory(batch.size(), options.steps);
  std::size_t history =
      recordings.empty() ? 0 : HistoryBytes(cloth_->view().num_dofs(), options.steps);
  if (choice.with_factors) history += FactorBytes(options.steps);
  const int most = SlotsThatFit(static_cast<int>(batch.size()), take, history);
  for (std::size_t first = 0; first < batch.size(); first += most) {
    const std::size_t count = std::min<std::size_t>(most, batch.size() - first);
    RolloutChunk(batch.subspan(first, count), options, choice,
                 recordings.empty() ? recordings : recordings.subspan(first, count),
                 results.subspan(first, count), failed.subspan(first, count));
  }
}

std::size_t DeviceEngine::FactorBytes(int steps) const {
  return sizeof(double) * cloth_->multifrontal().view().factor_size * steps;
}

// What is kept may take a part of what is free: the way back needs a workspace of its own.
DeviceEngine::HistoryChoice DeviceEngine::ChooseHistory(std::size_t rollouts, int steps) const {
  constexpr double kHistoryShare = 0.4;
  const double room = kHistoryShare * static_cast<double>(QueryMemory().free + memory_.bytes());
  const double states =
      static_cast<double>(rollouts) * HistoryBytes(cloth_->view().num_dofs(), steps);
  const double factors = static_cast<double>(rollouts) * FactorBytes(steps);
  return {states <= room, states + factors <= room};
}

DeviceEngine::RolloutRun DeviceEngine::RunRollouts(std::span<const RolloutInput> batch,
                                                   const RolloutOptions& options,
                                                   HistoryChoice choice, bool record) {
  const int slots = static_cast<int>(batch.size()), dofs = cloth_->view().num_dofs();
  StepWorkspace w{};
  const auto take = [&](Arena& arena, int n) { w = StepWorkspace::Take(arena, *cloth_, n); };
  Arena arena = MakeRoom(slots, take);
  take(arena, slots);
  auto history = std::make_shared<DeviceHistory>();
  history->device = device_.index;
  history->slots = slots;
  HistoryView kept{nullptr, nullptr, static_cast<std::int64_t>(slots) * dofs, w.step};
  if (record) {
    history->x = DeviceBuffer<double>(static_cast<std::size_t>(options.steps) * slots * dofs);
    history->v = DeviceBuffer<double>(history->x.size());
    if (choice.with_factors) {
      const std::int64_t stride = slots * cloth_->multifrontal().view().factor_size;
      history->factor = DeviceBuffer<double>(static_cast<std::size_t>(options.steps) * stride);
      w.factor = {history->factor.data(), w.step, stride};
    }
    kept.x = history->x.data();
    kept.v = history->v.data();
  }
  std::vector<const MaterialField*> fields;
  for (const RolloutInput& input : batch) fields.push_back(input.material);
  const DeviceMaterials materials(fields);
  UploadStarts(batch, w.x, w.v);
  Clear(w.failed, slots * sizeof(int));
  Clear(w.step, sizeof(int));
  const ShapeBatch shapes{slots, slots, nullptr, materials.views(), w.x};
  const Graph step(*streams_, [&] {
    streams_->ForEachGroup(slots, [&](int first, int count, cudaStream_t stream) {
      LaunchSolveStep(w, SliceBatch(shapes, first, count, dofs), first, options.h, stream);
      LaunchAdvanceGroup(w, kept, first, count, options.h, stream);
    });
    LaunchCountStep(w.step, 1, streams_->main());
  });
  const int done = RunSteps(step, options.steps, options.cancel);
  streams_->Synchronize();
  return {w, history, done};
}

std::vector<Recording> MakeRecordings(const std::shared_ptr<const DeviceHistory>& history,
                                      int steps) {
  std::vector<Recording> recordings;
  for (int i = 0; i < history->slots; ++i) {
    auto recording = std::make_shared<DeviceRecording>();
    recording->history = history;
    recording->slot = i;
    recording->steps = steps;
    recordings.push_back({{}, {}, {}, std::move(recording)});
  }
  return recordings;
}

void DeviceEngine::RolloutChunk(std::span<const RolloutInput> batch, const RolloutOptions& options,
                                HistoryChoice choice, std::span<Recording> recordings,
                                std::span<RolloutResult> results, std::span<char> failed) {
  const RolloutRun run = RunRollouts(batch, options, choice, !recordings.empty());
  std::vector<RolloutResult*> ends;
  for (RolloutResult& result : results) ends.push_back(&result);
  CollectEnds(run.workspace, run.done, options.steps, ends, failed);
  if (recordings.empty()) return;
  if (!choice.on_device) return Download(*cloth_, *run.history, batch, run.done, recordings);
  std::vector<Recording> all = MakeRecordings(run.history, run.done);
  std::move(all.begin(), all.end(), recordings.begin());
}

}  // namespace drape
