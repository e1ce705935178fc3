// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "cuda/engine/equilibria/equilibrium_engine.h"
#include "cuda/engine/resources/device_resources.h"
#include "cuda/engine/rollouts/rollout_engine.h"

namespace drape {

// What losses read of a batch's shapes on one device: derivatives of a readout, and losses with
// their gradients. Arguments are those of Backend; `failed` as in RolloutEngine.
class ReadoutEngine {
 public:
  // The engines work with the same resources.
  ReadoutEngine(DeviceResources& resources, RolloutEngine& rollouts, EquilibriumEngine& equilibria)
      : resources_(resources), rollouts_(rollouts), equilibria_(equilibria) {}

  void ReadoutTangents(std::span<const RolloutInput> batch,
                       std::span<const MaterialField* const> weights, const RolloutOptions& options,
                       const Readout& readout, std::span<ReadoutTangent> results,
                       std::span<char> failed);
  void EquilibriumReadoutTangents(std::span<const RolloutInput> batch,
                                  std::span<const MaterialField* const> weights,
                                  const Readout& readout, std::span<LinearReadout> results);
  // For readouts that a device knows, all of one kind.
  void LossGradients(std::span<const RolloutInput> batch, const RolloutOptions& options,
                     const ReadoutLoss& loss, std::span<LossGradient> results,
                     std::span<char> failed);

 private:
  std::size_t LossBytes(const DeviceReadout& readout) const;  // of one slot's loss
  // `first`: of the batch that `loss` knows.
  void LossChunk(std::span<const RolloutInput> batch, const RolloutOptions& options,
                 HistoryChoice choice, const ReadoutLoss& loss, std::size_t first,
                 std::span<LossGradient> results, std::span<char> failed);

  DeviceResources& resources_;
  RolloutEngine& rollouts_;
  EquilibriumEngine& equilibria_;
};

}  // namespace drape
