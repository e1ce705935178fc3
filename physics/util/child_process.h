// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace drape {

// The two kinds of child process: another program, and a piece of this one.

struct ProgramResult {
  int status = 0;  // 0: it succeeded; otherwise as waitpid reports it
  std::string output, errors;
};

// Starts a program, found on PATH and without a shell, on three descriptors, with no other open
// ones; `arguments` begins with its name. It is in a process group of its own, out of reach of
// Ctrl-C, and ends with the thread that started it. Its exit code is 127 when there is no such
// program.
pid_t StartProgram(const std::vector<std::string>& arguments, int in, int out, int errors);

// Runs a program, found on PATH and without a shell, and waits for it; `arguments` begins with its
// name. Its standard input is empty. Throws InputError when it cannot be started.
ProgramResult RunProgram(const std::vector<std::string>& arguments);

constexpr double kBytesPerMegabyte = 1e6;

struct ChildResult {
  bool cancelled = false;
  std::string output;       // what the work returned
  double peak_bytes = 0.0;  // largest resident memory of the child, that of its parent included
};

// Runs `work` in a forked child, so that its memory is its own and is measured separately. The
// parent must not have used a device before: a device context does not survive the fork. Nor do the
// stacks of other threads: what `work` needs lies on the heap or on that of the caller. When
// *cancel turns true the child is killed. An InputError or IoError of the child is thrown again
// here. Throws std::runtime_error when the child dies.
ChildResult RunInChild(const std::function<std::string()>& work, const std::atomic<bool>* cancel);

}  // namespace drape
