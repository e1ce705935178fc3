// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// printf into a string for one line of a table. Longer output is cut to 255 characters.
[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...);

}  // namespace drape
