// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/material/laws/law_kind.h"
#include "tools/cli/option_table.h"

namespace drape {

// Options that mean the same in many tools.
Option OutOption(std::string& folder);
Option LawOption(std::string& law);  // MakeLaw
Option LawOption(LawKind& law);
Option ThreadsOption(int& threads);  // rollouts at a time; 0: all cores
// A cloth (ParseMeshSpec), or several.
Option MeshOption(const std::string& key, Option::Value mesh, const std::string& doc);

}  // namespace drape
