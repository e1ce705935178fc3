// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/cli/option_table.h"

namespace drape {

// Provenance: the member of each summary from which its run can be repeated (repetition.h). A
// process has one record.

// Begins the record of a run with its command line. Files that are read from now on are configs.
void RecordCommand(int argc, char** argv);

// Records the options as they were read, defaults included. Files that are read from now on are
// inputs. `repeated`: the run that this one repeats with the same options, or nullptr; throws
// InputError where an input of that run has changed (CheckInputs). Call it before other threads are
// started.
void RecordRunOptions(const OptionTable& table, std::shared_ptr<const StoredRun> repeated);

// Records the value that another option has chosen for this one.
void RecordChoice(const std::string& key, const nlohmann::json& chosen);

// The record so far. Throws InputError where the process repeats a run and has read other files.
nlohmann::ordered_json MakeProvenance();

// The provenance of a part of the run, such as one fit of a study: without options and inputs,
// which are in the summary of the whole run.
nlohmann::ordered_json MakePartProvenance();

// Writes a summary with its provenance, atomically. Throws InputError.
void WriteWithProvenance(const std::string& path, nlohmann::ordered_json summary);

}  // namespace drape
