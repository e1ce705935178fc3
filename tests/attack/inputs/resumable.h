// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape::attack {

// Runs that can be stopped and continued, and what they store.
struct ResumableRun {
  std::string name;
  std::vector<std::string> command;  // writes to "out"; a second or two
  std::string resume = {};           // the option that continues; empty: the same command does
  std::vector<std::string> stored;   // files of its own that it reads back, below "out"; "cells/":
                                     // a file in this folder
};
const std::vector<ResumableRun>& ResumableRuns();

// Lists these runs and further ones, which are known by their inputs alike.
std::vector<ResumableRun> AllResumableRuns();

// The command that continues a run.
std::vector<std::string> ResumeCommand(const ResumableRun& run);

// A result without what differs from run to run: times, memory, and what follows from them. Text
// that is not JSON or a CSV table is returned unchanged.
std::string WithoutTimes(const std::string& file, const std::string& text);

// Whether a file is the same in each run but for times: not a log, a chart of times or a
// checkpoint.
bool IsReproducible(const std::string& file);

}  // namespace drape::attack
