// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "cuda/engine/resources/device_resources.h"
#include "cuda/engine/resources/step_workspace.h"
#include "cuda/engine/rollouts/device_history.h"

namespace drape {

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
