// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <semaphore.h>
#include <sys/resource.h>
#include <unistd.h>

#include <Eigen/Core>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <fstream>
#include <new>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "physics/util/text_format.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/progress.h"

namespace drape {
namespace {

std::atomic<bool> cancel_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");
sem_t wake_up;  // posted by each signal, and at the end of the run

extern "C" void OnCancelSignal(int) {
  const int before = errno;
  cancel_requested = true;
  sem_post(&wake_up);
  errno = before;
}

void HandleSignals() {
  struct sigaction action = {};
  action.sa_handler = OnCancelSignal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the limit becomes a write error, with its message
}

double ProcessorSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// A run that is cancelled saves what it has and ends. One that cannot do so soon, because it is in
// the middle of something that knows no interruption, is ended from here: what it has not published
// is dropped, and the files that it continues from are whole, as after a kill. A second signal ends
// it at once.
class InterruptWatch {
 public:
  explicit InterruptWatch(std::string tool) : tool_(std::move(tool)) {
    sem_init(&wake_up, 0, 0);
    HandleSignals();
    try {
      thread_ = std::thread([this] { Watch(); });
    } catch (const std::system_error&) {  // no more threads: the run must end by itself
    }
  }
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;
  ~InterruptWatch() {
    ended_ = true;
    sem_post(&wake_up);
    if (thread_.joinable()) thread_.join();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kPatience = 1.4;         // [s], of which the run has had
  static constexpr double kLeastProcessor = 0.9;   // so much of a processor [s],
  static constexpr double kLongestPatience = 8.0;  // but no longer than this on a busy machine
  static constexpr double kOneSignal = 0.5;        // [s] in which a signal may arrive twice
  static constexpr long kPollNanoseconds = 50'000'000;

  void Watch() {
    while (sem_wait(&wake_up) != 0) {
    }
    const Clock::time_point start = Clock::now();
    const double processor = ProcessorSeconds();
    while (!ended_) {
      const bool again = Wait();
      const double waited = std::chrono::duration<double>(Clock::now() - start).count();
      const bool had_time = waited > kPatience && ProcessorSeconds() - processor > kLeastProcessor;
      if (!ended_ && (had_time || waited > kLongestPatience || (again && waited > kOneSignal)))
        End();
    }
  }

  // True when a signal arrives within the interval of a poll.
  static bool Wait() {
    timespec until = {};
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += kPollNanoseconds;
    until.tv_sec += until.tv_nsec / 1'000'000'000;
    until.tv_nsec %= 1'000'000'000;
    return sem_timedwait(&wake_up, &until) == 0;
  }

  [[noreturn]] void End() const {
    OutputFolder::Abandon();
    std::fprintf(stderr,
                 "%s: interrupted in the middle of a long computation: its results so far are not "
                 "saved, earlier files are unchanged\n",
                 tool_.c_str());
    _exit(kExitCancelled);
  }

  std::string tool_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

// A file that is opened must not take the number of a standard stream that the caller has closed.
// Text for a closed stdout is an error; who closes stderr wants no messages.
void OpenStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && errno == EBADF)
      (void)!open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

// Warnings and errors on stderr, no log files, unless a flag says otherwise.
void StartLogging(const char* program) {
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_WARNING;
  google::InitGoogleLogging(program);
}

ExitCode ReportError(const std::string& tool, const std::string& message) {
  std::fprintf(stderr, "%s: error: %s\n", tool.c_str(), MakePrintableLine(message).c_str());
  return kExitBadInput;
}

// "4.2 GB".
std::string MemoryText(double bytes) { return Format("%.2f GB", 1e-9 * bytes); }

// The largest address space that the process has had [bytes].
double PeakAddressSpace() {
  constexpr double kKibibyte = 1024.0;
  std::ifstream status("/proc/self/status");
  for (std::string name; status >> name;) {
    double kibibytes = 0.0;
    if (name == "VmPeak:" && status >> kibibytes) return kKibibyte * kibibytes;
  }
  return 0.0;
}

std::string OutOfMemoryText() {
  rlimit limit = {};
  const double machine = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
  const bool limited = getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  return "out of memory: the run reserved " + MemoryText(PeakAddressSpace()) +
         " and needed more; " +
         (limited ? "the limit of its address space (ulimit -v) is " +
                        MemoryText(double(limit.rlim_cur))
                  : "the machine has " + MemoryText(machine));
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

ExitCode ReportOutcome(const std::string& tool, const ToolOutcome& outcome) {
  if (outcome.cancelled) return kExitCancelled;
  if (outcome.failure.empty()) return outcome.exit_code;
  std::fprintf(stderr, "%s: failed: %s\n", tool.c_str(),
               MakePrintableLine(outcome.failure).c_str());
  return kExitNumerical;
}

// What was written to stdout or stderr and did not arrive is an error, which the other one names.
ExitCode CloseStreams(const std::string& tool, ExitCode code) {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return ReportError(tool, std::string("stdout: cannot be written") +
                                 (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
  if (std::fflush(stderr) == 0 && std::ferror(stderr) == 0) return code;
  std::printf("%s: error: stderr: cannot be written, messages are lost\n", tool.c_str());
  std::fflush(stdout);
  return kExitBadInput;
}

ExitCode Run(int argc, char** argv, const OptionTable& table,
             const std::function<ToolOutcome(const RunControl& control)>& run) {
  try {
    if (ParseCommandLine(table, argc, argv) == ParseOutcome::kHelpShown) return kExitOk;
    const InterruptWatch watch(table.tool);
    const ToolOutcome outcome = RunWithProgress(table.tool, run);
    std::fputs(MakePrintable(outcome.text).c_str(), stdout);
    return ReportOutcome(table.tool, outcome);
  } catch (const std::bad_alloc&) {
    return ReportError(table.tool, OutOfMemoryText());
  } catch (const std::exception& error) {  // InputError, NotCompiled
    return ReportError(table.tool, error.what());
  }
}

}  // namespace

int RunTool(int argc, char** argv, const OptionTable& table,
            const std::function<ToolOutcome(const RunControl& control)>& run) {
  OpenStandardStreams();
  StartLogging(argv[0]);
  Eigen::setNbThreads(1);  // batches run in parallel instead, on --threads
  return CloseStreams(table.tool, Run(argc, argv, table, run));
}

}  // namespace drape
