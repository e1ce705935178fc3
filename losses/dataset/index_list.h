// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// "1,3-5" → {1, 3, 4, 5}: parses whole numbers from 1 to 9999 and ranges of them into an ascending
// list without repetition. An empty text is an empty list. Throws InputError (prefix `where`) that
// names the wrong part.
std::vector<int> ParseIndexList(const std::string& text, const std::string& where);

// The inverse, for messages and reports: {1, 3, 4, 5} → "1,3-5". `numbers` must ascend.
std::string IndexListText(const std::vector<int>& numbers);

}  // namespace drape
