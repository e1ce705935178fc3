// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

namespace drape {

// A program: drapefit VERB, or drape_VERB, a link to drapefit.
struct Program {
  const char* verb;
  const char* task;                    // heading of the list of verbs
  const char* summary;                 // one line of the list, at most 74 columns
  int (*main)(int argc, char** argv);  // nullptr: an executable of its own beside drapefit
};

// All programs, in the order of the list of verbs.
std::span<const Program> Programs();

// The program of a verb ("compare_optimisers" or "compare-optimisers"); nullptr where there is
// none.
const Program* FindProgram(std::string verb);

// The folder of the executable that runs, where the links to it are.
std::string ProgramFolder();

// The path of drape_VERB in a folder.
std::string ProgramPath(const std::string& folder, const std::string& verb);

// Returns whether a folder has an executable drape_VERB.
bool HasProgram(const std::string& folder, const std::string& verb);

}  // namespace drape
