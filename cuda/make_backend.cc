// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "cuda/cuda_backend.h"
#include "physics/errors.h"

namespace drape {

std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads) {
  if (name == "cpu") return MakeCpuBackend(std::move(model), threads);
  if (name == "cuda") return MakeCudaBackend(std::move(model));
  throw InputError("backend", "unknown name '" + name + "', expected cpu or cuda");
}

}  // namespace drape
