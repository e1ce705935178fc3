// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_backend.h"

namespace drape {

std::unique_ptr<Backend> MakeCudaBackend(std::shared_ptr<const ClothModel>) {
  throw NotCompiled("cuda", "the CUDA backend is not in this version, use the cpu backend");
}

}  // namespace drape
