// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/cli/option_table.h"

namespace drape {

// "a|b|c".
std::string JoinChoices(const std::vector<std::string>& choices, const char* separator);

// What the option is set to, as text that Set takes; before Parse its default.
std::string ValueText(const Option& option);

// The range of an option for a person: "0 … 5", "> 0", "≥ 1", or nothing.
std::string RangeText(const Option& option);

}  // namespace drape
