// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// What gnuplot writes to its standard output for a script: a picture where the script sets a
// terminal and no output. Throws InputError when gnuplot cannot be started or refuses the script,
// with its first line of complaint.
std::string RunGnuplot(const std::string& script);

}  // namespace drape
