// SPDX-License-Identifier: Apache-2.0
#pragma once

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

// Runs a program, found on PATH and without a shell, and waits for it; `arguments` begins with its
// name. `input` is its standard input, `environment` its variables ("NAME=value"), those of this
// process where it is empty. Throws InputError when it cannot be started.
ProgramResult RunProgram(const std::vector<std::string>& arguments, const std::string& input,
                         const std::vector<std::string>& environment = {});

constexpr double kBytesPerMegabyte = 1e6;

struct ChildResult {
  bool cancelled = false;
  std::string output;       // what the work returned
  double peak_bytes = 0.0;  // largest resident memory of the child, that of its parent included
};

// Runs `work` in a forked child, so that its memory is its own and is measured separately. The
// parent must not have used a device before: a device context does not survive the fork. When
// *cancel turns true the child is killed. An InputError or IoError of the child is thrown again
// here. Throws std::runtime_error when the child dies.
ChildResult RunInChild(const std::function<std::string()>& work, const std::atomic<bool>* cancel);

}  // namespace drape
