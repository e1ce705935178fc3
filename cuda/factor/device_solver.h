// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "cuda/device/device.h"
#include "physics/linalg/linear_solver.h"

namespace drape {

// A LinearSolver that factors one system at a time on a device, for a single large cloth, in the
// order of elimination that MakeLinearSolver has on the host. Copies may be used on threads of
// their own. Throws InputError where a front does not fit, CudaError, DeviceMemoryError.
std::unique_ptr<LinearSolver> MakeDeviceSolver(const BlockPattern& pattern,
                                               const DeviceInfo& device);

}  // namespace drape
