// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <vector>

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
  std::string text = {};               // for stdout
  std::vector<std::string> next = {};  // words of a command that continues here, below the text
  bool cancelled = false;              // exit code 130
  std::string failure = {};            // not empty: "tool: failed: …" on stderr and exit code 3
  ExitCode exit_code = kExitOk;        // otherwise
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

// The command of a Python script: Debian's python3, which has the packages that scripts need, or
// else the first python3 of PATH, and the script. The script is share/drapefit/`installed` beside
// installed programs, or `source` in the source tree above the build folder. If it is in neither,
// the last word is empty.
std::vector<std::string> ScriptCommand(const std::string& installed, const std::string& source);

// The programs, which tools/programs/front/drapefit.cc lists.
int BenchMain(int argc, char** argv);              // drape_bench
int CheckMain(int argc, char** argv);              // drape_check
int CompareMain(int argc, char** argv);            // drape_compare
int CompareOptimisersMain(int argc, char** argv);  // drape_compare_optimisers
int EquilibriaMain(int argc, char** argv);         // drape_equilibria
int ExportMain(int argc, char** argv);             // drape_export
int FabricsMain(int argc, char** argv);            // drape_fabrics
int FitMain(int argc, char** argv);                // drape_fit
int GarmentMain(int argc, char** argv);            // drape_garment
int GradientsMain(int argc, char** argv);          // drape_gradients
int MetricsMain(int argc, char** argv);            // drape_metrics
int PredictMain(int argc, char** argv);            // drape_predict
int ReportMain(int argc, char** argv);             // drape_report
int SimulateMain(int argc, char** argv);           // drape_simulate
int SpaceMain(int argc, char** argv);              // drape_space
int SpeedMain(int argc, char** argv);              // drape_speed
int StabilityMain(int argc, char** argv);          // drape_stability

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
