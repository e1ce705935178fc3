// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "physics/util/stored/stored_json.h"
#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// A staged or nested fit on disk. `key` says what is fitted and how; another key is rejected
// (CheckpointKey). Version 1 had no version, no checksum and nothing of an unfinished grid.
inline constexpr StoredFormat kCheckpointFormat = {"drapefit-checkpoint", 4};

// Writes atomically, exact to the last bit. Throws InputError when it cannot.
void WriteCheckpoint(const std::string& path, const std::string& key, const StagedFitState& state);

// A state from which RunNestedFit of this problem can continue. Nothing when there is no such file.
// Throws InputError, which names the file and the key, for a file that is damaged, is of another
// version or key, or says what this fit cannot have saved: other sizes, values out of range, a
// round that would have ended, guesses that are not of its grid, candidates that CheckCandidate
// refuses.
std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& key,
                                             const FitProblem& problem,
                                             const StagedFitOptions& options);

}  // namespace drape
