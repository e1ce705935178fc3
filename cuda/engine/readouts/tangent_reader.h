// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "cuda/engine/resources/device_resources.h"
#include "losses/readout/device_readout.h"

namespace drape {

// What a device needs to read the rollouts [first, first + count); all of one kind.
std::vector<const DeviceReadout*> CollectDeviceReadouts(const Readout& readout, std::size_t first,
                                                        std::size_t count);

// Shapes with their derivatives on the device, and the shapes on the host; null: not read.
struct TangentShapes {
  const double *x, *dx;  // [3V], [3V, kPaddedEntries] a slot
  std::span<const Eigen::VectorXd* const> host;
};
// What `readout` finds at the shapes and its derivatives, on the device for the readouts that it
// knows, otherwise on the host.
void ReadTangentShapes(const DeviceResources& resources, const TangentShapes& shapes,
                       const Readout& readout, std::span<LinearReadout* const> results);

}  // namespace drape
