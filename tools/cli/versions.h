// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace drape {

// Name and version of what a result rests on: drapefit and its commit, the compiler, Eigen,
// CHOLMOD.
std::vector<std::pair<std::string, std::string>> Versions();

}  // namespace drape
