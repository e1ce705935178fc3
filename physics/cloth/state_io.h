// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/cloth/state.h"

namespace drape {

// A state file is {"x": [[x, y, z], …], "v": [[x, y, z], …]}, one triple a vertex, in m and m/s.

// Throws InputError naming the file, the key and the index: syntax, a missing or unknown key, a
// count other than num_vertices, a triple of another length, a number that is not finite.
State ReadState(const std::string& path, int num_vertices);

// Writes atomically; numbers read back bit for bit. CHECKs equal sizes and finite numbers.
// Throws InputError when the file cannot be written.
void WriteState(const std::string& path, const State& state);

}  // namespace drape
