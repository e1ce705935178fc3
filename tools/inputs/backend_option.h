// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "physics/simulation/backend.h"
#include "tools/cli/option_table.h"

namespace drape {

// --backend of each program that runs rollouts.
Option BackendOption(std::string& backend);

// MakeBackend; `log`, unless it is empty, is told in one line what was chosen and why.
std::unique_ptr<Backend> MakeLoggedBackend(const std::string& name,
                                           std::shared_ptr<const ClothModel> model, int threads,
                                           const std::function<void(const std::string&)>& log);

}  // namespace drape
