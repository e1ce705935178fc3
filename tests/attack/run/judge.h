// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/attack/run/process.h"

namespace drape::attack {

// The rules by which each run is judged. All are here, so that no class of attacks has its own.

enum class Verdict {
  kAny,      // taken or refused
  kRefused,  // bad input: exit code 2
  kTaken     // good input: not exit code 2
};

struct Expectation {
  Verdict verdict = Verdict::kAny;
  std::vector<std::string> named = {};  // an error names one of these: the file, key or option
  std::vector<std::string> results = {"out"};  // files and folders that it may write
  bool keeps_results = true;                   // at exit code 2 they have not changed
  // By the signal or limit that it was sent; only SIGKILL excuses what it left.
  bool may_be_killed = false;
  bool prints_numbers = true;  // its results may not be nan or inf
};

// Relative path → "file" and content, "folder", or "link" and its target. Links are not followed.
using FolderState = std::map<std::string, std::string>;
FolderState ReadFolder(const std::string& folder);

// Which rules a run broke, one sentence each; empty: none. `before` and `after` are the
// states of the run's folder.
std::vector<std::string> JudgeRun(const Request& request, const Outcome& outcome,
                                  const Expectation& expectation, const FolderState& before,
                                  const FolderState& after);

// The rules for an error message alone; `text` without the end of line.
std::vector<std::string> JudgeMessage(const std::string& text,
                                      const std::vector<std::string>& named);

// Text with control bytes and bytes that are not UTF-8 made visible, at most `longest` bytes.
std::string Visible(const std::string& text, std::size_t longest = 300);

// A file that an attack tries to make a program create.
inline constexpr char kPlanted[] = "PLANTED";

}  // namespace drape::attack
