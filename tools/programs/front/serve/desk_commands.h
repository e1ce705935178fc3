// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace drape {

struct DeskOptions {
  std::string out = "out/desk";  // folder of the photographs and jobs
  std::string fit_config;        // of fits; empty: that of drapefit
  int port = 0;                  // 0: a free one
  int jobs = 1;                  // that run at a time, beside the measurement of photographs
  int threads = 0;               // of each program; 0: all cores
};

// A program of drapefit with its arguments; the verb is empty for drapefit SAMPLES.
struct DeskCommand {
  std::string verb;
  std::vector<std::string> arguments;

  std::vector<std::string> Words() const;  // with the path of the program
  std::string Text() const;                // as a shell reads it
};

// The columns of samples.csv that a photograph's fields set.
inline constexpr const char* kFieldColumns[] = {
    "fabric",       "sample",        "specimen", "face",       "warp",
    "mass",         "diameter",      "support",  "focal_35mm", "threshold",
    "cloth_points", "ground_points", "date",     "operator",   "customer"};

// Returns whether a photograph is measured again when that field changes.
bool IsOfMeasurement(const std::string& field);

// Throws InputError unless it is {"name": "text", …} with these names and plain texts.
void CheckFields(const nlohmann::json& fields);

// A text of a client as it is kept and shown: printable, in one line, of at most 100 bytes.
std::string PlainText(const std::string& text);

// The commands that do the work of an item, in turn.
std::vector<DeskCommand> ListCommands(const std::string& id, const nlohmann::json& record,
                                      const DeskOptions& options);

// The table of the photographs of a fit, which are in its folder, named by their ids.
std::string SamplesText(const std::vector<std::pair<std::string, nlohmann::json>>& pictures);

// What the page shows of a finished photograph (drape_photo's summary) or job: {"dc": …}, {"fits":
// [names of fits], "page": name of the report}.
nlohmann::json ReadResult(const std::string& folder, const nlohmann::json& record);

// The outlines of a fit that runs, as drape_fit writes them; null before it has some.
nlohmann::json ReadOutlines(const std::string& folder);

// The files of an item that the page may have: regular ones at most two folders deep, no links.
std::vector<std::string> ListFiles(const std::string& folder);

// The last lines of a log, at most so many bytes.
std::string ReadTail(const std::string& path, long bytes);

}  // namespace drape
