// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/readout/outline_stages.h"
#include "cuda/readout/silhouette_slot.h"

namespace drape {

// What losses read of the shapes of a batch; slots in device memory, their status 0 before.

// radius, dof and value.
void LaunchOutlines(const OutlinePlan& plan, const OutlineSlot* slots, int count,
                    cudaStream_t stream);
// Then loss and dL_dx.
void LaunchOutlineLoss(const OutlinePlan& plan, const OutlineSlot* slots, int count,
                       cudaStream_t stream);

// coverage.
void LaunchCoverage(const SilhouettePlan& plan, const SilhouetteSlot* slots, int count,
                    cudaStream_t stream);
// Then loss and dL_dx.
void LaunchSilhouetteLoss(const SilhouettePlan& plan, const SilhouetteSlot* slots, int count,
                          cudaStream_t stream);

}  // namespace drape
