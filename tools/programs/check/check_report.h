// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "solver/studies/validation/check.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// What drape_check checks.
struct CheckToolOptions {
  SceneInput scene;
  CheckOptions check;
};

// On stdout: group, name, value, bound and ok or FAIL a row, then how many failed.
void PrintCheckTable(const std::vector<CheckRow>& rows);

// Points into `options`, which outlives it.
OptionTable CheckTable(CheckToolOptions& options);

}  // namespace drape
