// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace drape {

// Times of equal runs [s].
struct RunTimes {
  std::vector<double> wall;
  std::vector<double> cpu;  // processor time of all threads
};

// Repeats `run` at most so many times, and no more once so many seconds of wall clock are spent.
RunTimes TimeRuns(const std::function<void()>& run, int repeats, double seconds);

// The median, and slowest − fastest, of at least one time.
double MedianTime(std::vector<double> times);
double TimeSpread(const std::vector<double>& times);

// Wall clock [s], for differences.
double WallSeconds();

}  // namespace drape
