// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include "physics/backend.h"

namespace drape {

// A feature that is not in this build; `why` says how that can be changed. The tools print what()
// and exit with 2.
class NotCompiled : public std::runtime_error {
 public:
  NotCompiled(const std::string& feature, const std::string& why)
      : std::runtime_error("no " + feature + " support: " + why) {}
};

// The batch of rollouts on a CUDA device. Not in this version: throws NotCompiled.
std::unique_ptr<Backend> MakeCudaBackend(std::shared_ptr<const ClothModel> model);

// name: cpu or cuda. Throws InputError for any other.
std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads);

}  // namespace drape
