// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "solver/fit/protocol/staged_fit.h"

namespace drape {

// A staged fit on disk. `job` names what is fitted and how; a checkpoint of another job is refused.

// Writes atomically, exact to the last bit. Throws InputError when it cannot.
void WriteCheckpoint(const std::string& path, const std::string& job, const StagedFitState& state);

// Nothing when there is no such file. Throws InputError for a file that is damaged or of another
// job.
std::optional<StagedFitState> ReadCheckpoint(const std::string& path, const std::string& job);

}  // namespace drape
