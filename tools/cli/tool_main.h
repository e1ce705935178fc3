// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
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

}  // namespace drape
