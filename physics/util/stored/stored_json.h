// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace drape {

// A JSON file that a program writes for itself and reads back: an object with "format", "version"
// and "checksum", the CRC-32 of its other members. So a file that was damaged, or changed by hand,
// is found before a number of it is used.
struct StoredFormat {
  const char* name;
  int version;
};

// The text of a file with these members, an object that has neither format, version nor checksum,
// and back: the members as they were written. Parsing throws InputError (prefix `where`) for text
// that is damaged, is of another format or version, or has another checksum.
std::string StoredJsonText(const StoredFormat& format, const nlohmann::json& members);
nlohmann::json ParseStoredJson(const std::string& text, const std::string& where,
                               const StoredFormat& format);

// Throws InputError where a file of another format stands at the path, which no program of ours has
// written. To be called before the first WriteStoredJson.
void CheckStored(const std::string& path, const StoredFormat& format);

// Write and read such a file, atomically and bit for bit. Both throw InputError.
void WriteStoredJson(const std::string& path, const StoredFormat& format,
                     const nlohmann::json& members);
nlohmann::json ReadStoredJson(const std::string& path, const StoredFormat& format);

}  // namespace drape
