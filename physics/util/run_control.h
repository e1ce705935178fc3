// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace drape {

// How a long computation talks to its caller. Empty members are not used; a computation calls the
// functions from one thread at a time.
struct RunControl {
  const std::atomic<bool>* cancel = nullptr;  // ends the computation early when it turns true
  // fraction of the work that is done, 0 … 1, and what is going on.
  std::function<void(double fraction, const std::string& note)> progress = {};
  std::function<void(const std::string& line)> log = {};

  bool cancelled() const { return cancel != nullptr && cancel->load(std::memory_order_relaxed); }
  void Report(double fraction, const std::string& note) const {
    if (progress) progress(fraction, note);
  }
  void Log(const std::string& line) const {
    if (log) log(line);
  }
};

}  // namespace drape
