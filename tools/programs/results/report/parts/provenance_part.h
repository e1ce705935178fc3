// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

// The command, machine, build, inputs and options of a run, by the member "provenance" of its
// summary, and the command that repeats it; nothing without that member.
std::string ProvenanceHtml(const ResultFolder& folder);

// Words as a shell takes them: those that it would change are quoted.
std::string ShellLine(const std::vector<std::string>& words);

}  // namespace drape
