// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// The only way for a text into a gnuplot script: a literal between single quotes, in which gnuplot
// runs no commands and expands nothing. What could end the literal is replaced: control characters
// by blanks, a straight quote by a curved one; and bytes that are not UTF-8 by question marks.
std::string QuoteForGnuplot(const std::string& text);

// What gnuplot writes to its standard output for a script: a picture where the script sets a
// terminal and no output. Neither the user's
// start-up files nor the locale have a say. Throws InputError when gnuplot
// cannot be started or rejects the script, with its message.
std::string RunGnuplot(const std::string& script);

}  // namespace drape
