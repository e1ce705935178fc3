// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/stability/cases/stability_map.h"
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

// The row of one run without its end of line, "inputs,results", and back: adds it to `runs`.
// Parsing throws InputError, prefix `where`.
std::string StabilityRow(const std::string& inputs, const StabilityRun& run);
void ParseStabilityRow(const std::string& row, const std::string& where, StabilityRuns& runs);

// The cases of all maps in their order, each once.
std::vector<StabilityCase> DistinctCases(std::span<const StabilityMap> maps);

// Where a run is kept as soon as it has ended. Called by one thread at a time. May throw.
using KeepStabilityRun = std::function<void(const std::string& inputs, const StabilityRun& run)>;

// Runs those cases that are not among `runs` on `threads` threads, keeps them and adds them to
// `runs`. False when cancelled. Throws InputError where a scene cannot be made, and what `keep`
// throws.
bool SurveyStability(StabilityRunner& runner, std::span<const StabilityCase> cases, int threads,
                     const KeepStabilityRun& keep, const RunControl& control, StabilityRuns& runs);

// The same of all cases of some maps; each run is appended to the file at `path`, runs.csv.
bool SurveyStability(StabilityRunner& runner, std::span<const StabilityMap> maps, int threads,
                     const std::string& path, const RunControl& control, StabilityRuns& runs);

}  // namespace drape
