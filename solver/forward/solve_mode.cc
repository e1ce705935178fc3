// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/solve_mode.h"

#include "physics/util/errors.h"

namespace drape {

SolveMode ParseSolveMode(const std::string& text) {
  if (text == "dynamic") return SolveMode::kDynamic;
  if (text == "static") return SolveMode::kStatic;
  throw InputError("solve", "unknown name '" + text + "', expected dynamic or static");
}

}  // namespace drape
