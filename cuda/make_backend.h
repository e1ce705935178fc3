// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "physics/simulation/backend.h"

namespace drape {

// name: cpu, cuda, or auto (cuda where SurveyCuda says that it is usable). Throws InputError for
// any other. *choice, when given, says what was chosen and why.
std::unique_ptr<Backend> MakeBackend(const std::string& name,
                                     std::shared_ptr<const ClothModel> model, int threads,
                                     std::string* choice = nullptr);

}  // namespace drape
