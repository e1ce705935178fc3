// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

namespace drape {

// The CPU seconds of work() on this thread; other programs on the machine do not count.
template <class Work>
double Seconds(const Work& work) {
  const auto now = [] {
    timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
  };
  const double start = now();
  work();
  return now() - start;
}

}  // namespace drape
