// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// The only way for a text into a gnuplot script: a literal between single quotes, in which gnuplot
// runs no commands and expands nothing. Control characters, which would end the literal, become
// blanks, and bytes that are no UTF-8 become question marks.
std::string QuoteForGnuplot(const std::string& text);

// What gnuplot writes to its standard output for a script: a picture where the script sets a
// terminal and no output. The user's start-up files are not read. Throws InputError when gnuplot
// cannot be started or rejects the script, with the first line of its message.
std::string RunGnuplot(const std::string& script);

}  // namespace drape
