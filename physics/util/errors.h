// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace drape {

// Bad input from outside the program: a file, a key, a value. The message is one line that says
// where the error is, what was found and what was expected. The tools print what() and exit with
// status 2. Programmer errors are CHECKs (glog); numerical failures are returned as a status.
class InputError : public std::runtime_error {
 public:
  // where: "cloth.obj:17" or "configs/a.json: key 'h'"; problem: "face has 4 corners, expected 3".
  InputError(const std::string& where, const std::string& problem)
      : std::runtime_error(where + ": " + problem) {}
};

}  // namespace drape
