// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
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

// One row per check: group, name, value, bound and ok or FAIL; then how many failed.
std::string CheckTableText(const std::vector<CheckRow>& rows);

// Points into `options`, which outlives it.
OptionTable CheckTable(CheckToolOptions& options);

// The program drape_check.
int CheckMain(int argc, char** argv);

}  // namespace drape
