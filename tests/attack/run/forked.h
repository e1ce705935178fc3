// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace drape::attack {

// Calls of this program's own functions, in a child process that a crash ends.

struct ForkedFailure {
  int index = 0;
  std::vector<std::string> reasons;
};

// Calls try_one(i) for i < count, which returns what is wrong. A call that crashes, or takes more
// than `seconds`, is one failure; the next continues in a new child. Must not be called beside
// threads of this process.
std::vector<ForkedFailure> TryForked(int count, double seconds,
                                     const std::function<std::vector<std::string>(int)>& try_one);

}  // namespace drape::attack
