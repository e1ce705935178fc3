// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"

#include <glog/logging.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>

#include "tools/cli/progress.h"

namespace drape {
namespace {

std::atomic<bool> cancel_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");

extern "C" void OnCancelSignal(int) {
  if (cancel_requested.exchange(true)) _exit(kExitCancelled);
}

void HandleSignals() {
  struct sigaction action = {};
  action.sa_handler = OnCancelSignal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the limit becomes a write error, with its message
}

// Warnings and errors on stderr, no log files, unless a flag says otherwise.
void StartLogging(const char* program) {
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_WARNING;
  google::InitGoogleLogging(program);
}

ExitCode ReportError(const std::string& tool, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "%s: error: %s\n", tool.c_str(), message.c_str());
  return kExitBadInput;
}

// "drape_fit" → "fit".
std::string ProgressName(const std::string& tool) {
  constexpr char kPrefix[] = "drape_";
  return tool.starts_with(kPrefix) ? tool.substr(sizeof kPrefix - 1) : tool;
}

ToolOutcome RunWithProgress(const std::string& tool,
                            const std::function<ToolOutcome(const RunControl&)>& run) {
  Progress progress(ProgressName(tool));
  return run({.cancel = &cancel_requested,
              .progress = [&](double fraction,
                              const std::string& note) { progress.Update(fraction, note); },
              .log = [&](const std::string& line) { progress.Say(line); }});
}

ExitCode Finish(const std::string& tool, const ToolOutcome& outcome) {
  std::fputs(outcome.text.c_str(), stdout);
  if (outcome.cancelled) return kExitCancelled;
  if (outcome.failure.empty()) return outcome.exit_code;
  std::fprintf(stderr, "%s: failed: %s\n", tool.c_str(), outcome.failure.c_str());
  return kExitNumerical;
}

}  // namespace

int RunTool(int argc, char** argv, const OptionTable& table,
            const std::function<ToolOutcome(const RunControl& control)>& run) {
  StartLogging(argv[0]);
  Eigen::setNbThreads(1);  // batches run in parallel instead, on --threads
  try {
    if (ParseCommandLine(table, argc, argv) == ParseOutcome::kHelpShown) return kExitOk;
    HandleSignals();
    return Finish(table.tool, RunWithProgress(table.tool, run));
  } catch (const std::exception& error) {  // InputError, NotCompiled, or out of memory
    return ReportError(table.tool, error.what());
  }
}

}  // namespace drape
