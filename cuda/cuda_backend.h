// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "physics/backend.h"

namespace drape {

// A feature that this build was made without. The tools print what() and exit with 2.
class NotCompiled : public std::runtime_error {
 public:
  explicit NotCompiled(const std::string& feature)
      : std::runtime_error("this build has no " + feature + " support") {}
};

// The batch of rollouts on a CUDA device. Throws NotCompiled in a build without it.
std::unique_ptr<Backend> MakeCudaBackend(std::shared_ptr<const ClothModel> model);

// name: cpu or cuda. Throws InputError for any other.
std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads);

}  // namespace drape
