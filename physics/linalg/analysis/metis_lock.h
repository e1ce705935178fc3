// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>

namespace drape {

// Hold it during each call of METIS, which seeds the one random number generator of the process
// at its start: calls at the same time would take numbers from one another, and give another order
// and other last digits of results.
inline std::mutex& MetisLock() {
  static std::mutex one_at_a_time;
  return one_at_a_time;
}

}  // namespace drape
