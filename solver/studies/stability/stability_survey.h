// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "physics/util/run_control.h"
#include "solver/studies/stability/stability_map.h"
#include "solver/studies/stability/stability_runner.h"

namespace drape {

// Finished runs by StabilityInputs.
using StabilityRuns = std::map<std::string, StabilityRun>;

// runs.csv: a line "# …" that says what all runs share, the names of the columns, one row per run.
// An unfinished last line, of a run that was cut off, is dropped. Throws InputError where the file
// is another than WriteStabilityRuns writes, or its first line is another than `shared`.
StabilityRuns ReadStabilityRuns(const std::string& path, const std::string& shared);
void WriteStabilityRuns(const std::string& path, const std::string& shared,
                        const StabilityRuns& runs);

// Runs the cases of all maps that are not among `runs`, each once, on `threads` threads, and adds
// them; a row is appended to the file at `path` as soon as its run has ended. False when cancelled.
// Throws InputError where the file cannot be written or a scene cannot be made.
bool SurveyStability(StabilityRunner& runner, std::span<const StabilityMap> maps, int threads,
                     const std::string& path, const RunControl& control, StabilityRuns& runs);

}  // namespace drape
