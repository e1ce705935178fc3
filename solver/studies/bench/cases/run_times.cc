// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/cases/run_times.h"

#include <time.h>

#include <algorithm>
#include <chrono>

namespace drape {
namespace {

double CpuSeconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

double WallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

RunTimes TimeRuns(const std::function<void()>& run, int repeats, double seconds) {
  RunTimes times;
  const double clock = WallSeconds();
  do {
    const double wall = WallSeconds(), cpu = CpuSeconds();
    run();
    times.wall.push_back(WallSeconds() - wall);
    times.cpu.push_back(CpuSeconds() - cpu);
  } while (static_cast<int>(times.wall.size()) < repeats && WallSeconds() - clock < seconds);
  return times;
}

double MedianTime(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  const std::size_t n = times.size();
  return 0.5 * (times[(n - 1) / 2] + times[n / 2]);
}

double TimeSpread(const std::vector<double>& times) {
  const auto [least, most] = std::minmax_element(times.begin(), times.end());
  return *most - *least;
}

}  // namespace drape
