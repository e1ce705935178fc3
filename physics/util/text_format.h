// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace drape {

// printf into a string. A number that is not finite appears as "none".
[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...);

// A number beyond a limit, in so many decimals, or in as many more as tell the two apart: "3.04"
// beside 3.
std::string FormatBeyond(double value, double limit, int decimals);

// Words as a shell reads them, whatever they hold. Bytes that a terminal would not show as a
// character are escaped.
std::string ShellLine(const std::vector<std::string>& words);

// The length in bytes of the UTF-8 character at `at`; 0 where there is none.
std::size_t Utf8Length(std::string_view text, std::size_t at);
bool IsUtf8(std::string_view text);

// A text that holds names or parts of files, as it may be shown to a person: control characters but
// tabs and ends of line, marks that turn the direction of writing, and bytes that are not UTF-8
// appear as \xNN, so that none of them reaches a terminal; of a word of more than 200 bytes the
// middle is left out.
std::string MakePrintable(std::string_view text);

// A printable text in one line of at most 390 bytes. The middle of a longer line is left out.
std::string MakePrintableLine(std::string_view text);

}  // namespace drape
