// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <string>

namespace drape {

// How a long computation communicates with its caller. Members that are empty are not used. A
// computation calls the functions from one thread at a time.
struct RunControl {
  const std::atomic<bool>* cancel = nullptr;  // ends the computation early when it turns true
  // Receives the completed fraction of the work, 0 … 1, and a note on the current task.
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

// Calls work(i), 0 ≤ i < count, on so many threads, the calling one among them, until *cancel turns
// true; passes on the first exception.
void RunInThreads(int count, int threads, const std::atomic<bool>* cancel,
                  const std::function<void(int)>& work);

}  // namespace drape
