// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace drape {

struct ChildResult {
  bool cancelled = false;
  std::string output;       // what the work returned
  double peak_bytes = 0.0;  // largest resident memory of the child, that of its parent included
};

// Runs `work` in a forked child, so that its memory is its own and is measured alone. The parent
// must not have used a device before: it does not survive the fork. When *cancel turns true the
// child is ended. InputError in the child is thrown again here; throws std::runtime_error when the
// child dies.
ChildResult RunInChild(const std::function<std::string()>& work, const std::atomic<bool>* cancel);

}  // namespace drape
