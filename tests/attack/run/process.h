// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/tools/run_process.h"

namespace drape::attack {

// What standard output or error of a program is.
enum class Stream {
  kFile,    // read back by the attack
  kClosed,  // no descriptor
  kFull,    // /dev/full, where each write fails
  kBroken,  // a pipe whose reader has gone
  kStuck    // a full pipe that nobody reads
};

using test::kCanLimitMemory;

double SecondsSince(std::chrono::steady_clock::time_point start);

// Bounds of one run; 0: none.
struct Limits {
  double seconds = 10.0;  // times kSlowdown; then it is sent SIGINT and counted as cancelled
  double seconds_after_signal = 20.0;  // processor time within which it must end then [s]
  // Address space, of which each thread takes some.
  double memory_gb = 4.0 + 0.25 * std::thread::hardware_concurrency();
  long file_bytes = 0;             // largest file that it may write
  int files = 0;                   // open files
  double processor_seconds = 0.0;  // the system sends SIGXCPU
};

struct Signal {
  int number = 0;         // 0: none
  double after = 0.0;     // [s]
  double patience = 0.0;  // from the signal until the program is killed [s]; 0: see Limits
};

struct Request {
  std::vector<std::string> command;  // the path of the program first
  std::map<std::string, std::optional<std::string>> environment = {};  // changes; nothing: unset
  Limits limits = {};
  Signal signal = {};
  bool input = true;  // false: standard input is closed
  Stream out = Stream::kFile, err = Stream::kFile;
};

struct Outcome {
  int exit_code = -1;  // −1: it was ended by `signal`
  int signal = 0;
  bool cancelled = false;     // it was sent SIGINT at the limit of time
  bool hung = false;          // it did not end then, and was killed
  bool left_process = false;  // a process of its group outlived it
  double seconds = 0.0;
  bool was_caught = false;        // when the signal of the request came, the program handled it
  double answer_seconds = 0.0;    // from the signal of the request to the end
  double waiting_per_core = 0.0;  // threads of the machine that ran or waited to run meanwhile
  std::string threads;            // what each thread did when it was killed
  std::string out, err;
};

// Runs a program in `folder` to its end, in a process group of its own.
Outcome RunProgramIn(const std::string& folder, const Request& request);

// The same as a line for a shell, with what the limits and streams need.
std::string ShellLine(const Request& request);

// One word for a shell, whatever bytes it has.
std::string ShellWord(const std::string& text);

}  // namespace drape::attack
