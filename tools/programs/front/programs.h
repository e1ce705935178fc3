// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/cli/option_table.h"

namespace drape {

// A program that answers --help=json.
struct Program {
  std::string verb;      // "fit" of drape_fit
  nlohmann::json table;  // as TableJson (tools/cli/option_text.h) writes it
};

// The folder of the executable that runs, where the other programs are.
std::string ProgramFolder();

// The path of the program of a verb ("fit", "compare_optimisers" or "compare-optimisers"); empty
// where there is none.
std::string FindProgram(const std::string& folder, const std::string& verb);

// The verbs of the programs in a folder, by the alphabet.
std::vector<std::string> FindVerbs(const std::string& folder);

// The programs in a folder, by the alphabet; without those that do not answer.
std::vector<Program> ReadPrograms(const std::string& folder);

}  // namespace drape
