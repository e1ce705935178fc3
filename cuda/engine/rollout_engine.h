// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "cuda/engine/device_resources.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

namespace drape {

// Whether a rollout wants derivatives by the numbers of DynamicsEntry.
inline bool WantsTangent(const RolloutInput& input) {
  return input.tangent != nullptr && input.tangent->dynamics;
}
inline bool WantsAdjoint(const RolloutInput& input) {
  return input.adjoint != nullptr && input.adjoint->dynamics;
}

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
  DeviceResources& resources_;
};

}  // namespace drape
