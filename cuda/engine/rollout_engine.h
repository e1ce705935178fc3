// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "cuda/engine/device_resources.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

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

// What a batch leaves on the device, in the resources' memory: valid until their next batch.
struct RolloutRun {
  StepWorkspace workspace;                 // x, v: the ends
  std::shared_ptr<DeviceHistory> history;  // empty unless recorded
  int steps;                               // done
};
struct AdjointRun {
  double *adj_x, *adj_v;  // ∂L/∂start, [3V, columns] a slot
  DeviceGradient sums;
  std::vector<int> failed;  // of each slot
  int steps;                // done
};

// Rollouts on one device, and their derivatives. Results that the device could not find (a pivot
// that is not positive, a number that is not finite) are marked in `failed`, for the host to
// decide.
class RolloutEngine {
 public:
  explicit RolloutEngine(DeviceResources& resources) : resources_(resources) {}

  // recordings: empty, or one per rollout.
  void Rollouts(std::span<const RolloutInput> batch, const RolloutOptions& options,
                std::span<Recording> recordings, std::span<RolloutResult> results,
                std::span<char> failed);
  void Tangents(std::span<const RolloutInput> batch, std::span<const MaterialField* const> weights,
                const RolloutOptions& options, std::span<TangentResult> results,
                std::span<char> failed);
  // All recordings have the same number of steps, all dL_dx the same number of columns.
  void Adjoints(std::span<const RolloutInput> batch, std::span<const Recording* const> recordings,
                std::span<const RowMatrix* const> dL_dx, const RolloutOptions& options,
                std::span<AdjointResult> results, std::span<char> failed);

 private:
  RolloutRun RunRollouts(std::span<const RolloutInput> batch, const RolloutOptions& options,
                         HistoryChoice choice, bool record);
  // dL_dx: of the ends, [3V, columns] a slot.
  AdjointRun RunAdjoint(std::span<const RolloutInput> batch,
                        std::span<const Recording* const> recordings, int columns,
                        const std::vector<double>& dL_dx, const RolloutOptions& options);
  void CollectEnds(const StepWorkspace& workspace, int steps, int wanted_steps,
                   std::span<RolloutResult* const> results, std::span<char> failed) const;
  void DownloadTangents(const double* from, std::span<TangentResult> results,
                        RowMatrix TangentResult::*part) const;

  DeviceResources& resources_;
};

}  // namespace drape
