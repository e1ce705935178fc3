// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// Where the programs are, and what is installed beside them.

// The folder of the executable that runs, where the links to it are.
std::string ProgramFolder();

// The path of drape_VERB in a folder.
std::string ProgramPath(const std::string& folder, const std::string& verb);

// Returns whether a folder has an executable drape_VERB.
bool HasProgram(const std::string& folder, const std::string& verb);

// Finds configs/ of an installation, of a bundle, or of the sources of a build, from the folder of
// the programs. Throws InputError, prefix `what`, where it is not there.
std::string FindConfigs(const std::string& folder, const std::string& what);

}  // namespace drape
