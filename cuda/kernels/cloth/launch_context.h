// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include "cuda/kernels/cloth/cloth_view.h"

namespace drape {

// What the kernels over a batch of shapes work on, and where they are launched.
struct LaunchContext {
  const ClothView& cloth;
  ShapeBatch batch;
  const Law& law;  // its tables lie on the device
  cudaStream_t stream;
};

}  // namespace drape
