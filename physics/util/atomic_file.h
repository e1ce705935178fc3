// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <string_view>

namespace drape {

// Reading and writing of whole files, and the text of numbers in them.

// Replaces the file at `path` in one step: the content is written to a temporary file in the same
// folder, which is flushed to the disk and then renamed. A reader sees the old file or the new one,
// never a part of it. On any failure the old file survives and the temporary file is removed.
// Throws InputError when the folder is missing or not writable, when the disk is full, or when the
// path is a folder.
void WriteFileAtomically(const std::string& path, std::string_view content);

// The same, with a function that writes the content. An exception that it throws is passed on, and
// the old file survives.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& writer);

// Returns the bytes of the file. Throws InputError when it is missing, unreadable or a folder.
std::string ReadWholeFile(const std::string& path);

// Appends the shortest decimal text (at most 17 digits) that reads back to the same double, on
// every platform and in every locale. CHECKs that the value is finite.
void AppendNumber(std::string& text, double value);

}  // namespace drape
