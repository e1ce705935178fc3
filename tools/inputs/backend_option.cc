// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/backend_option.h"

#include <utility>

#include "cuda/make_backend.h"

namespace drape {

Option BackendOption(std::string& backend) {
  return {.key = "backend",
          .value = &backend,
          .doc = "device of the rollouts; auto: all CUDA devices if there are any, else the CPU",
          .choices = {"auto", "cpu", "cuda"}};
}

std::unique_ptr<Backend> MakeLoggedBackend(const std::string& name,
                                           std::shared_ptr<const ClothModel> model, int threads,
                                           const RunControl& control) {
  std::string device;
  std::unique_ptr<Backend> backend = MakeBackend(name, std::move(model), threads, &device);
  control.Log("running on " + device);
  return backend;
}

}  // namespace drape
