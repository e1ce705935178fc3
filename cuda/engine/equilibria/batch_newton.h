// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "cuda/engine/resources/device_resources.h"

namespace drape {

// Newton's method for a batch of drapes at rest that fits into the device's memory: the decisions
// are those of physics/simulation/statics/statics.h, one NewtonControl per rollout, the shapes stay
// on the device.
void FindEquilibria(DeviceResources& resources, std::span<const RolloutInput> batch,
                    const EquilibriumOptions& options, std::span<EquilibriumResult> results);

// Takes what FindEquilibria needs for n rollouts, to learn how large it is.
void TakeNewtonWorkspace(Arena& arena, const DeviceCloth& cloth, int n);

}  // namespace drape
