// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// printf into a string, for a line of a table: at most 255 characters.
[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...);

}  // namespace drape
