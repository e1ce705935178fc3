// SPDX-License-Identifier: Apache-2.0
#include "physics/util/run_control.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "physics/util/errors.h"

namespace drape {
namespace {

TEST(RunInThreads, RunsEachOnce) {
  for (const int threads : {1, 3, 20}) {
    std::vector<std::atomic<int>> runs(10);
    RunInThreads(10, threads, nullptr, [&](int i) { ++runs[i]; });
    for (const std::atomic<int>& count : runs) EXPECT_EQ(count, 1);
  }
}

// A child process that the work forks keeps the stack of this thread alone.
TEST(RunInThreads, OneOfThemIsTheCaller) {
  const std::thread::id caller = std::this_thread::get_id();
  RunInThreads(3, 1, nullptr, [&](int) { EXPECT_EQ(std::this_thread::get_id(), caller); });
}

TEST(RunInThreads, PassesAnExceptionOn) {
  std::atomic<int> done = 0;
  EXPECT_THROW(RunInThreads(8, 2, nullptr,
                            [&](int i) {
                              if (i == 3) throw InputError("cell", "bad");
                              ++done;
                            }),
               InputError);
}

TEST(RunInThreads, RunsNothingOnceCancelled) {
  const std::atomic<bool> cancel = true;
  std::atomic<int> done = 0;
  RunInThreads(8, 2, &cancel, [&](int) { ++done; });
  EXPECT_EQ(done, 0);
}

}  // namespace
}  // namespace drape
