// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cuda/engine/device_resources.h"

namespace drape {

// States of a batch of rollouts on a device, [steps, slots, 3V] in elimination order, and the
// factors of all steps where there was room for them.
struct DeviceHistory {
  int device, slots;
  DeviceBuffer<double> x, v;
  DeviceBuffer<double> factor;  // [steps, slots, factor_size], or empty
};
// One rollout of it.
struct DeviceRecording final : BackendRecording {
  std::shared_ptr<const DeviceHistory> history;
  int slot = 0, steps = 0;
};

// Where the states of a recorded batch go, and whether its factors are kept too.
struct HistoryChoice {
  bool on_device = false, with_factors = false;
};
// The states may take a part of the free memory: the adjoint pass needs a workspace of its own.
HistoryChoice ChooseHistory(const DeviceResources& resources, std::size_t rollouts, int steps);

// The size of one rollout's states and factors [bytes].
std::size_t HistoryBytes(const DeviceCloth& cloth, int steps);
std::size_t FactorBytes(const DeviceCloth& cloth, int steps);

// The recordings of all slots of a history, after `steps` steps.
std::vector<Recording> MakeRecordings(const std::shared_ptr<const DeviceHistory>& history,
                                      int steps);
// Downloads these recordings in the host's form.
void DownloadRecordings(const DeviceCloth& cloth, const DeviceHistory& history,
                        std::span<const RolloutInput> batch, int steps,
                        std::span<Recording> recordings);

int CountSteps(const Recording& recording);

// Where the states of each slot lie: in a history on the device, or uploaded from the host.
class HistoryTable {
 public:
  HistoryTable(const DeviceCloth& cloth, std::span<const Recording* const> recordings, int steps);
  const HistorySlot* slots() const { return slots_.data(); }

 private:
  HistorySlot Upload(const DeviceCloth& cloth, const Recording& recording, int steps);

  std::vector<DeviceBuffer<double>> uploaded_;
  DeviceBuffer<HistorySlot> slots_;
};

// The factors of the recordings' steps, when they are those of neighbouring slots of one history;
// base is null otherwise. step: the present one, on the device.
FactorPlace FindKeptFactors(std::span<const Recording* const> recordings, std::int64_t factor_size,
                            const int* step);

}  // namespace drape
