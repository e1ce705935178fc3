// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tests/attack/inputs/readers/readers.h"

namespace drape::attack {

// Which rules a reader breaks at a damaged file, one sentence each; empty: none. It may take the
// file, as long as what it reads is sound, or throw an InputError whose message obeys JudgeMessage,
// but for control bytes and length: the programs escape and shorten as they print; then *refused
// becomes true.
std::vector<std::string> ReadDamaged(const Reader& reader, const std::string& path,
                                     bool* refused = nullptr);

}  // namespace drape::attack
