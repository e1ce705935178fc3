// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/check.h"
#include "tools/scene_input.h"

namespace drape {

// What drape_check checks.
struct CheckToolOptions {
  SceneInput scene;
  CheckOptions check;
};

// On stdout: group, name, value, bound and ok or FAIL a row, then how many failed.
void PrintCheckTable(const std::vector<CheckRow>& rows);

}  // namespace drape
