// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// A staged fit on disk. `key` says what is fitted and how; another key is rejected (CheckpointKey).

// Writes atomically, exact to the last bit. Throws InputError when it cannot.
void WriteCheckpoint(const std::string& path, const std::string& key, const StagedFitState& state);

// Nothing when there is no such file. Throws InputError for a file that is damaged or of another
// key.
std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& key);

}  // namespace drape
