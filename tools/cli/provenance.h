// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "physics/util/json_input.h"
#include "tools/cli/option_table.h"

namespace drape {

// A run that is repeated from its summary: drape_fit --config=OLD/summary.json --out=NEW.

// A file that a run has read.
struct InputFile {
  std::string path;  // as the program opened it
  std::uintmax_t bytes = 0;
  std::string sha256;  // of its bytes, 64 hexadecimal digits

  auto operator<=>(const InputFile&) const = default;  // NOLINT(modernize-use-nullptr)
};
InputFile DescribeInput(const std::string& path, std::string_view content);

// A text as JSON can hold it: bytes that are not UTF-8 appear as \xNN.
std::string MakeUtf8(std::string_view text);

// A run, as the member "provenance" of a summary describes it; its options are read by
// OptionTable::ReadConfig.
struct StoredRun {
  std::string summary;            // file that it was read from
  std::string working_directory;  // where its relative paths begin
  std::string build;              // that of BuildText, or empty
  std::vector<InputFile> inputs;
  bool is_changed = false;  // the command line makes another run of it
};

// Throws InputError where the provenance is not that of a whole run of the program `tool`.
StoredRun ReadStoredRun(const JsonInput& provenance, const std::string& summary,
                        const std::string& tool);

// Throws InputError, naming the file, unless each input is there with the bytes that the run had
// read.
void CheckInputs(const StoredRun& run);

// The cores of this machine, at least 1.
int CountCores();

// Provenance: the member of each summary from which its run can be repeated. A process has one
// record.

// Begins the record of a run with its command line. Files that are read from now on are configs.
void RecordCommand(int argc, char** argv);

// Records the options as they were read, defaults included. Files that are read from now on are
// inputs. `repeated`: the run that this one repeats with the same options, or nullptr; throws
// InputError where an input of that run has changed (CheckInputs). Call it before other threads are
// started.
void RecordRunOptions(const OptionTable& table, std::shared_ptr<const StoredRun> repeated);

// Throws InputError where results at this path would replace an input of the run or the summary of
// another program.
void CheckKeeps(const std::string& path);

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
