// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace drape {

// Writes a new file beside `path`, flushes it to the disk and renames it: a reader sees the old
// content or the new, never a part. InputError naming the path and the system's reason; the old
// file is then untouched and nothing is left behind.
void WriteFileAtomically(const std::string& path, const std::vector<uint8_t>& bytes);

}  // namespace drape
