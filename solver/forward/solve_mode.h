// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/options/enum_names.h"

namespace drape {

// How a drape is found from its start.
enum class SolveMode {
  kDynamic,  // the shape after time steps
  kStatic    // the equilibrium near the start
};
constexpr auto EnumNames(SolveMode) {
  return MakeNames<SolveMode>({{SolveMode::kStatic, "static"}, {SolveMode::kDynamic, "dynamic"}});
}

}  // namespace drape
