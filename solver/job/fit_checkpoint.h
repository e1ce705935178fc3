// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "physics/util/stored/stored_json.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/job/fit_input.h"

namespace drape {

// What must be equal for a checkpoint to be continued: all that determines the fit of one table,
// which is the same for all models. Throws InputError for experiments in memory: a readout has no
// content to know it by.
std::string CheckpointKey(const FitSpec& spec, const FitData& data, const FitInput& input);

// A staged or nested fit on disk. `key` says what is fitted and how (CheckpointKey). A file with
// the right checksum and key is trusted.
inline constexpr StoredFormat kCheckpointFormat = {"drapefit-checkpoint", 7};

// Writes atomically, exact to the last bit. Throws IoError when it cannot.
void WriteCheckpoint(const std::string& path, const std::string& key, const StagedFitState& state);

// The state that was saved. Nothing when there is no such file. Throws InputError for a file that
// is damaged, of another version, or of another key, of which it names the first difference.
std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& key);

}  // namespace drape
