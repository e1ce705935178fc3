// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>

#include "tools/cli/option_table.h"

namespace drape {

enum ExitCode {
  kExitOk = 0,
  kExitCheckFailed = 1,  // drape_check, drape_validate: a check does not hold
  kExitBadInput = 2,     // one line on stderr; what was written before is untouched
  kExitNumerical = 3,    // the computation failed; the summary says how
  kExitCancelled = 130   // by Ctrl-C or SIGTERM; what was reached is on disk
};

// What each main() does around its one library call: logging, the command line
// into the table, `body`, and one line "tool: error: …" on stderr for whatever it throws (exit 2).
// The first SIGINT or SIGTERM sets `cancel`, a second one ends the process at once.
int RunTool(int argc, char** argv, const OptionTable& table,
            const std::function<ExitCode(const std::atomic<bool>& cancel)>& body);

}  // namespace drape
