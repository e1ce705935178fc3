// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/cli/option_table.h"

namespace drape {

// "a|b|c".
std::string JoinChoices(const std::vector<std::string>& choices, const char* separator);

// The value of an option as text that Set takes; before parsing, its default.
std::string ValueText(const Option& option);

// The value of an option as JSON of its own type, which ReadConfig takes.
nlohmann::json ValueJson(const Option& option);

// The manual page of a program, in roff and UTF-8.
std::string ManPage(const OptionTable& table);

// The name nearest to what a user wrote, where one is near enough to be meant (Levenshtein's
// distance up to half the length, rounded up); else empty.
std::string SuggestName(const std::string& written, const std::vector<std::string>& names);

// The range of an option for a person: "0 … 5", "> 0", "≥ 1", or nothing.
std::string RangeText(const Option& option);

}  // namespace drape
