// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "physics/simulation/backend.h"

namespace drape {

// name: cpu, cuda, or auto (cuda where SurveyCuda says that it is usable). Throws InputError for
// any other. *device, when given, names what it runs on: "2 CPU threads", "NVIDIA H200". Why auto
// found no GPU is logged at --v=1.
std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads,
                                     std::string* device = nullptr);

// The GPUs that auto runs on, "NVIDIA H200"; empty: none.
std::string UsableGpu();

}  // namespace drape
