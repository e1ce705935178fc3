// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace drape::test {

struct ProcessResult {
  int exit_code = -1;  // 128 + the signal that ended it
  std::string out, err;
};

struct ProcessLimits {
  long file_bytes = 0;              // largest file that it may write (RLIMIT_FSIZE); 0: any
  std::string interrupt_when = {};  // sends SIGINT once this path exists; empty: never
  int interrupt_lines = 0;          // and is a file of so many lines
  double interrupt_after = 0.0;     // and this much later [s]
  int interrupt_signal = 2;         // instead of SIGINT
  long address_bytes = 0;           // largest address space (RLIMIT_AS); 0: any
  std::string folder = {};          // working directory; empty: that of the test
  std::string out_file = {};        // takes its stdout; empty: the result
  std::string err_file = {};        // the same of stderr
  std::vector<std::pair<std::string, std::string>> environment =
      {};              // set beside those of the test
  bool charts = true;  // false: a study finds no matplotlib, which takes it seconds
};

// Whether limits leave a program room: sanitizers reserve terabytes of addresses, and LLVM's OpenMP
// and thread sanitizer map files of their own as they start.
#ifdef __clang__
inline constexpr bool kCanLimitFiles = false;
inline constexpr bool kCanLimitMemory =
    !__has_feature(thread_sanitizer) && !__has_feature(address_sanitizer);
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kCanLimitFiles = true, kCanLimitMemory = false;
#else
inline constexpr bool kCanLimitFiles = true, kCanLimitMemory = true;
#endif

// How much longer a program takes with a sanitizer.
inline constexpr double kSlowdown = kCanLimitMemory ? 1.0 : 4.0;

// Runs a program to its end and returns what it printed.
ProcessResult RunProcess(const std::vector<std::string>& command, const ProcessLimits& limits = {});

}  // namespace drape::test
