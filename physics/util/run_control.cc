// SPDX-License-Identifier: Apache-2.0
#include "physics/util/run_control.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace drape {

void RunInThreads(int count, int threads, const std::atomic<bool>* cancel,
                  const std::function<void(int)>& work) {
  std::atomic<int> next = 0;
  std::exception_ptr error;
  std::mutex mutex;
  const auto run = [&] {
    for (int i = next++; i < count; i = next++) {
      if (cancel != nullptr && cancel->load()) return;
      try {
        work(i);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!error) error = std::current_exception();
        return;
      }
    }
  };
  {
    std::vector<std::jthread> pool;
    for (int i = 1; i < std::min(threads, count); ++i) pool.emplace_back(run);
    run();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace drape
