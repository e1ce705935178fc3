// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "physics/util/stored/stored_json.h"
#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// A staged or nested fit on disk. `key` says what is fitted and how (CheckpointKey). A file with
// the right checksum and key is trusted.
inline constexpr StoredFormat kCheckpointFormat = {"drapefit-checkpoint", 5};

// Writes atomically, exact to the last bit. Throws InputError when it cannot.
void WriteCheckpoint(const std::string& path, const std::string& key, const StagedFitState& state);

// The state that was saved. Nothing when there is no such file. Throws InputError for a file that
// is damaged, of another version, or of another key, of which it names the first difference.
std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& key);

}  // namespace drape
