// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <string>

namespace drape {

// "simulate  42 %  step 42 of 100, 12 s left". seconds: since the start.
std::string ProgressText(const std::string& what, double fraction, double seconds,
                         const std::string& note);

// Progress of a run on stderr: one line that is rewritten on a terminal, else a plain line every
// few seconds; a run that is done sooner prints nothing there.
class Progress {
 public:
  explicit Progress(std::string what);
  Progress(std::string what, std::FILE* out, bool is_terminal);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  // clears the line on a terminal

  // A line of its own above the progress; a run that is done sooner than that leaves it out.
  void Say(const std::string& line) { unsaid_ += line + "\n"; }
  // fraction of all work, 0 … 1.
  void Update(double fraction, const std::string& note);

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_, unsaid_;
  std::FILE* out_;
  bool is_terminal_;
  Clock::time_point start_, last_;
  bool on_screen_ = false;
};

}  // namespace drape
