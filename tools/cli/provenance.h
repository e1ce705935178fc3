// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/cli/option_table.h"

namespace drape {

// Where results are from: the member "provenance" of each summary, from which its run can be
// repeated (repetition.h). One record belongs to the process.

// Begins the record of a run with its command line. What is read from now on is a config.
void RecordCommand(int argc, char** argv);

// Records the options as they were read, defaults included. What is read from now on is an input.
// `repeated`: the run that this one repeats with the same options, or nullptr; throws InputError
// where an input of that run has changed (CheckInputs). Call it before other threads are started.
void RecordRunOptions(const OptionTable& table, std::shared_ptr<const StoredRun> repeated);

// Records the value that another option has chosen for this one.
void RecordChoice(const std::string& key, const nlohmann::json& chosen);

// The record so far. Throws InputError where the process repeats a run and has read other files.
nlohmann::ordered_json MakeProvenance();

// The same for the summary of a part of the run, such as a fit of a study: without options and
// inputs, which the summary of the whole has.
nlohmann::ordered_json MakePartProvenance();

// Writes a summary with its provenance, atomically. Throws InputError.
void WriteWithProvenance(const std::string& path, nlohmann::ordered_json summary);

}  // namespace drape
