// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"

namespace drape {

enum ExitCode {
  kExitOk = 0,
  kExitCheckFailed = 1,  // drape_check: a check failed
  kExitBadInput = 2,     // one line on stderr; earlier output files are unchanged
  kExitNumerical = 3,    // the computation failed; the summary says how
  kExitCancelled = 130   // by Ctrl-C or SIGTERM; the results so far are on disk
};

// The outcome of a program.
struct ToolOutcome {
  std::string text = {};         // for stdout
  bool cancelled = false;        // exit code 130
  std::string failure = {};      // not empty: "tool: failed: …" on stderr and exit code 3
  ExitCode exit_code = kExitOk;  // otherwise
};

// The main() of a program around its one library call: sets up the log, reads the command line into
// the table, shows the progress of `run` on stderr, then prints its text. Whatever `run` throws
// becomes one line "tool: error: …" on stderr and exit code 2. The first SIGINT or SIGTERM cancels
// the run; a second one ends the process at once.
int RunTool(int argc, char** argv, const OptionTable& table,
            const std::function<ToolOutcome(const RunControl& control)>& run);

template <class Options>
int ToolMain(int argc, char** argv, OptionTable (*table)(Options& options),
             ToolOutcome (*run)(const Options& options, const RunControl& control)) {
  Options options;
  return RunTool(argc, argv, table(options),
                 [&](const RunControl& control) { return run(options, control); });
}

// Estimates the time left of a run from the fractions of its work that it reports.
class TimeLeft {
 public:
  // seconds: since the start, not falling. fraction: 0 … 1.
  void Update(double seconds, double fraction);
  // Time left [s], estimated from all reports except the latest one: the tasks of a batch end
  // together, and the first of them reports a long time with little work. No value while too little
  // is done.
  std::optional<double> Seconds() const { return left_; }

 private:
  std::optional<double> Estimate() const;

  std::optional<double> left_;
  double seconds_ = 0.0, fraction_ = 0.0;
  // Time and work so far. Older work counts less, because the rate changes from stage to stage.
  double recent_seconds_ = 0.0, recent_work_ = 0.0;
};

// "simulate  42 %  step 42 of 100, about 12 s left".
std::string ProgressText(const std::string& what, double fraction, std::optional<double> left,
                         const std::string& note);

// Shows the progress of a run on stderr. A terminal gets one line that is rewritten; a file gets a
// plain line every few seconds. A run that ends sooner prints nothing.
class Progress {
 public:
  explicit Progress(std::string what);
  Progress(std::string what, std::FILE* out, bool is_terminal);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();  // clears the line on a terminal

  // Prints a line of its own above the progress. A run that ends before the first progress omits
  // it.
  void Say(const std::string& line) { unsaid_ += line + "\n"; }
  // fraction of all work, 0 … 1.
  void Update(double fraction, const std::string& note);

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_, unsaid_;
  std::FILE* out_;
  bool is_terminal_;
  Clock::time_point start_, last_;
  TimeLeft time_left_;
  double shown_ = 0.0;  // fraction
  bool on_screen_ = false;
};

}  // namespace drape
