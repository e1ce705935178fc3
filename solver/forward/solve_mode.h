// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// How a drape is found from its start.
enum class SolveMode {
  kDynamic,  // the shape after time steps
  kStatic    // the equilibrium near the start
};
// "dynamic" or "static". Throws InputError for any other.
SolveMode ParseSolveMode(const std::string& text);

}  // namespace drape
