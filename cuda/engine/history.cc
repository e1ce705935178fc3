// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/history.h"

#include <utility>

namespace drape {

std::size_t HistoryBytes(const DeviceCloth& cloth, int steps) {
  return 2 * sizeof(double) * cloth.view().num_dofs() * steps;
}

std::size_t FactorBytes(const DeviceCloth& cloth, int steps) {
  return sizeof(double) * cloth.multifrontal().view().factor_size * steps;
}

HistoryChoice ChooseHistory(const DeviceResources& resources, std::size_t rollouts, int steps) {
  constexpr double kHistoryShare = 0.4;
  const double room = kHistoryShare * static_cast<double>(resources.FreeBytes());
  const double states = static_cast<double>(rollouts) * HistoryBytes(resources.cloth(), steps);
  const double factors = static_cast<double>(rollouts) * FactorBytes(resources.cloth(), steps);
  return {states <= room, states + factors <= room};
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

void DownloadRecordings(const DeviceCloth& cloth, const DeviceHistory& history,
                        std::span<const RolloutInput> batch, int steps,
                        std::span<Recording> recordings) {
  const int dofs = cloth.view().num_dofs();
  const std::vector<double> x = Download(history.x.data(), history.x.size());
  const std::vector<double> v = Download(history.v.data(), x.size());
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

int CountSteps(const Recording& recording) {
  const auto* own = dynamic_cast<const DeviceRecording*>(recording.backend.get());
  return own != nullptr ? own->steps : static_cast<int>(recording.factor.size());
}

HistoryTable::HistoryTable(const DeviceCloth& cloth, std::span<const Recording* const> recordings,
                           int steps) {
  const int dofs = cloth.view().num_dofs();
  std::vector<HistorySlot> slots;
  for (const Recording* recording : recordings) {
    if (const auto* own = dynamic_cast<const DeviceRecording*>(recording->backend.get())) {
      const std::int64_t at = static_cast<std::int64_t>(own->slot) * dofs;
      slots.push_back({own->history->x.data() + at, own->history->v.data() + at,
                       static_cast<std::int64_t>(own->history->slots) * dofs});
    } else {
      slots.push_back(Upload(cloth, *recording, steps));
    }
  }
  slots_ = DeviceBuffer<HistorySlot>(slots);
}

HistorySlot HistoryTable::Upload(const DeviceCloth& cloth, const Recording& recording, int steps) {
  const int dofs = cloth.view().num_dofs();
  std::vector<double> x(static_cast<std::size_t>(steps) * dofs), v(x.size());
  for (int k = 0; k < steps; ++k) {
    cloth.ToEliminationOrder(recording.x[k].data(), 1, 1, x.data() + std::size_t{1} * k * dofs);
    cloth.ToEliminationOrder(recording.v[k + 1].data(), 1, 1, v.data() + std::size_t{1} * k * dofs);
  }
  uploaded_.emplace_back(x);
  uploaded_.emplace_back(v);
  return {uploaded_[uploaded_.size() - 2].data(), uploaded_.back().data(), dofs};
}

FactorPlace FindKeptFactors(std::span<const Recording* const> recordings, std::int64_t factor_size,
                            const int* step) {
  const auto* first = dynamic_cast<const DeviceRecording*>(recordings[0]->backend.get());
  if (first == nullptr || first->history->factor.size() == 0) return {nullptr};
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const auto* own = dynamic_cast<const DeviceRecording*>(recordings[i]->backend.get());
    if (own == nullptr || own->history != first->history ||
        own->slot != first->slot + static_cast<int>(i))
      return {nullptr};
  }
  double* base = const_cast<double*>(first->history->factor.data());
  return {base + first->slot * factor_size, step, first->history->slots * factor_size};
}

}  // namespace drape
