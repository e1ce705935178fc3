// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <string_view>

namespace drape {

// Whole files in, whole files out.

// Replaces the file at `path` in one step: the content goes to a temporary file in the same folder,
// which is then flushed to the disk and renamed. A reader sees the old or the new file, never a
// part; on any failure the old file survives and the temporary file is removed.
// Throws InputError (folder missing or not writable, disk full, path is a folder).
void WriteFileAtomically(const std::string& path, std::string_view content);

// The same with a writer for the content; what it throws is passed on, and the old file survives.
void WriteFileAtomically(const std::string& path, const std::function<void(std::ostream&)>& writer);

// The bytes of the file. Throws InputError when it is missing, unreadable or a folder.
std::string ReadWholeFile(const std::string& path);

// Appends the shortest decimal text (at most 17 digits) that reads back to the same double, on each
// platform and in each locale. CHECKs that the value is finite.
void AppendNumber(std::string& text, double value);

}  // namespace drape
