// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/programs/front/programs.h"

namespace drape {

// The verbs by task, one a line with what its program says of itself (at most 100 columns); those
// of no task come last, under "others".
std::string VerbsText(const std::vector<Program>& programs);

// "unknown verb 'fti', did you mean 'fit'? (drapefit --help lists all)".
std::string UnknownVerbText(const std::string& verb, const std::vector<std::string>& verbs);

}  // namespace drape
