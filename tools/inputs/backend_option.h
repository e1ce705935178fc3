// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "physics/simulation/backend.h"
#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"

namespace drape {

// --backend of each program that runs rollouts.
Option BackendOption(std::string& backend);

// MakeBackend; one line of the log names what it runs on.
std::unique_ptr<Backend> MakeLoggedBackend(const std::string& name,
                                           std::shared_ptr<const ClothModel> model, int threads,
                                           const RunControl& control);

}  // namespace drape
