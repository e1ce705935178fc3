// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

namespace drape {

// What the finished runs in a folder were made with, key → value, in a JSON file beside them.

// Throws InputError where the file has another value for one of the keys. A key that it lacks is of
// runs that are not there yet, and no file has none. `runs`: what they are called, "fits".
void CheckStudySettings(const std::string& path, const std::map<std::string, std::string>& settings,
                        const std::string& runs);

// Adds the settings to those of the file, which appears as a whole: processes with other keys may
// use the same folder. Throws InputError.
void AddStudySettings(const std::string& path, const std::map<std::string, std::string>& settings);

}  // namespace drape
