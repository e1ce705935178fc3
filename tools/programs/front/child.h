// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// Runs a program with the standard streams of this process and returns its exit code, or 128 and
// the signal that ended it. SIGINT and SIGTERM that arrive meanwhile are passed on to it, and this
// process waits for it to save its results. `command` begins with its path. Throws InputError when
// it cannot be started.
int RunAttached(const std::vector<std::string>& command);

// Becomes the program, with the further arguments of `argv`, which ends in a null pointer. Throws
// InputError when that fails; otherwise does not return.
[[noreturn]] void Become(const std::string& path, const std::vector<std::string>& arguments);

}  // namespace drape
