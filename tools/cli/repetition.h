// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "physics/util/json_input.h"

namespace drape {

// A run that is repeated from its summary: drape_fit --config=OLD/summary.json --out=NEW.

// A file that a run has read.
struct InputFile {
  std::string path;  // as the program opened it
  std::uintmax_t bytes = 0;
  std::string sha256;  // of its bytes, 64 hexadecimal digits

  auto operator<=>(const InputFile&) const = default;
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

}  // namespace drape
