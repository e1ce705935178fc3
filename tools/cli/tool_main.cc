// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <malloc.h>
#include <poll.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "physics/util/text_format.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr double kTerminalInterval = 0.1, kPlainInterval = 5.0;  // [s]
// The time [s] between plain lines; drape_serve, whose page shows them, asks for less.
double PlainInterval() {
  static const char* const wanted = std::getenv("DRAPEFIT_PROGRESS_SECONDS");
  if (wanted == nullptr) return kPlainInterval;
  return std::clamp(std::atof(wanted), kTerminalInterval, kPlainInterval);
}
constexpr std::chrono::seconds kReadingInterval{15};
constexpr double kShownStep = 0.01;                           // of the work, on a terminal
constexpr double kLeastSeconds = 2.0, kLeastFraction = 0.05;  // before a time left is shown
// Work counts e times less after this share of the time so far, or after kLeastMemory [s].
constexpr double kMemory = 1.0, kLeastMemory = 20.0;
constexpr char kClearLine[] = "\r\033[K";

std::string DurationText(double seconds) {
  const auto whole = static_cast<long>(std::ceil(seconds));
  if (whole < 100) return std::to_string(whole) + " s";
  if (whole < 6000) return std::to_string((whole + 59) / 60) + " min";
  return std::to_string((whole + 3599) / 3600) + " h";
}

double Seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

void TimeLeft::Update(double seconds, double fraction) {
  const double elapsed = seconds - seconds_, work = std::max(0.0, fraction - fraction_);
  const double memory = std::max(kLeastMemory, kMemory * seconds);
  const double kept = std::exp(-elapsed / memory);
  left_ = Estimate();
  if (left_) *left_ = std::max(0.0, *left_ - elapsed);
  recent_seconds_ = kept * recent_seconds_ + elapsed;
  recent_work_ = kept * recent_work_ + work;
  seconds_ = seconds;
  fraction_ = std::max(fraction_, fraction);
}

std::optional<double> TimeLeft::Estimate() const {
  if (seconds_ < kLeastSeconds || fraction_ < kLeastFraction || recent_work_ <= 0.0)
    return std::nullopt;
  return (1.0 - fraction_) * recent_seconds_ / recent_work_;
}

std::string ProgressText(const std::string& what, double fraction, std::optional<double> left,
                         const std::string& note) {
  std::string text = what + "  " + std::to_string(std::lround(100 * fraction)) + " %";
  if (!note.empty()) text += "  " + note;
  if (left && *left > 0 && fraction < 1) text += ", about " + DurationText(*left) + " left";
  return text;
}

Progress::Progress(std::string what) : Progress(std::move(what), stderr, isatty(STDERR_FILENO)) {}

Progress::Progress(std::string what, std::FILE* out, bool is_terminal)
    : what_(std::move(what)),
      out_(out),
      is_terminal_(is_terminal),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (on_screen_) std::fputs(kClearLine, out_);
}

void Progress::Update(double fraction, const std::string& note) {
  const Clock::time_point now = Clock::now();
  time_left_.Update(Seconds(now - start_), fraction);
  // The tasks of a batch end together, and the last of their reports is the one that matters.
  const bool advanced = is_terminal_ && on_screen_ && fraction >= shown_ + kShownStep;
  if (!advanced && Seconds(now - last_) < (is_terminal_ ? kTerminalInterval : PlainInterval()))
    return;
  last_ = now;
  shown_ = fraction;
  const std::string text = ProgressText(what_, fraction, time_left_.Seconds(), note);
  if (is_terminal_) std::fputs(kClearLine, out_);
  std::fprintf(out_, is_terminal_ ? "%s%s" : "%s%s\n", MakePrintable(unsaid_).c_str(),
               MakePrintableLine(text).c_str());
  unsaid_.clear();
  std::fflush(out_);
  on_screen_ = is_terminal_;
}

namespace {

std::atomic<bool> cancel_requested = false, run_has_ended = false;

std::atomic<pid_t> watcher = 0;  // the thread that waits for signals

// Hands a signal over to the thread that waits for it. Threads that a library made before main,
// such as those of OpenBLAS, do not block it. Without a waiting thread there is nothing to save.
extern "C" void HandOver(int signal) {
  if (watcher == 0 || tgkill(getpid(), watcher, signal) != 0) _exit(kExitCancelled);
}

sigset_t CancelSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

double ProcessorSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// Returns whether no other thread of this process runs or waits for a processor or a disk.
bool IsIdle() {
  std::error_code error;
  for (fs::directory_iterator task("/proc/self/task", error), end; !error && task != end;
       task.increment(error)) {
    if (task->path().filename() == std::to_string(watcher)) continue;
    std::string text;
    std::getline(std::ifstream(task->path() / "stat"), text);
    const std::size_t state = text.rfind(") ");
    if (state != std::string::npos && std::strchr("RD", text[state + 2]) != nullptr) return false;
  }
  return !error;
}

// Waits for SIGINT and SIGTERM. All threads block them, because METIS takes a SIGTERM for an error
// while it works. A cancelled run saves what it has and ends. If it cannot end soon, because a
// library call knows no interruption, this class ends the process: it drops unpublished files, and
// checkpoints stay whole, as after a kill. A second signal ends the process at once.
class InterruptWatch {
 public:
  // Construct it before any other thread: threads inherit the blocked signals.
  explicit InterruptWatch(std::string tool) : tool_(std::move(tool)) {
    const sigset_t signals = CancelSignals();
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, HandOver);  // not SIG_IGN
    std::signal(SIGXFSZ, SIG_IGN);  // a file over the limit becomes a write error, with its message
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    try {
      thread_ = std::thread([this] { Watch(); });
    } catch (const std::system_error&) {  // no more threads: a signal ends the process
      pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
    }
  }
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;
  ~InterruptWatch() {
    ended_ = true;
    if (!thread_.joinable()) return;
    // Wakes it up.
    pthread_kill(thread_.native_handle(), SIGTERM);  // NOLINT(bugprone-bad-signal-to-kill-thread)
    thread_.join();
    watcher = 0;
    const sigset_t signals = CancelSignals();
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr double kPatience = 1.4;         // [s], of which the run has had
  static constexpr double kLeastProcessor = 0.9;   // so much of a processor [s] to save files,
  static constexpr double kLongestPatience = 8.0;  // but no longer than this on a busy machine
  static constexpr double kOneSignal = 0.5;        // [s] in which a signal may arrive twice
  static constexpr int kIdlePolls = 4;             // so often in sequence a run that waits is idle
  static constexpr long kPollNanoseconds = 50'000'000;
  static constexpr std::chrono::milliseconds kLastResort{600};

  void Watch() {
    watcher = gettid();
    const sigset_t signals = CancelSignals();
    int signal = 0;
    while (sigwait(&signals, &signal) != 0) {
    }
    if (ended_) return;
    cancel_requested = true;
    const Clock::time_point start = Clock::now();
    const double processor = ProcessorSeconds();
    for (int idle = 0; !ended_;) {
      const timespec poll = {0, kPollNanoseconds};
      const bool again = sigtimedwait(&signals, nullptr, &poll) > 0;
      const double waited = std::chrono::duration<double>(Clock::now() - start).count();
      idle = IsIdle() ? idle + 1 : 0;
      const bool had_processor = ProcessorSeconds() - processor > kLeastProcessor ||
                                 !OutputFolder::IsAnyOpen() || idle >= kIdlePolls;
      const bool had_time = waited > kPatience && had_processor;
      if (!ended_ && (had_time || waited > kLongestPatience || (again && waited > kOneSignal)))
        End();
    }
  }

  // Ends the process whatever locks and streams other threads hold.
  [[noreturn]] void End() const {
    try {
      std::thread([] {
        std::this_thread::sleep_for(kLastResort);
        _exit(kExitCancelled);
      }).detach();
    } catch (const std::system_error&) {  // no more threads
    }
    OutputFolder::Abandon();
    const std::string text =
        tool_ + ": interrupted" +
        (run_has_ended || OutputFolder::HasAnyPublished()
             ? ": its files show the results so far\n"
             : " in the middle of a long computation: its results so far are not saved, earlier "
               "files are unchanged\n");
    pollfd err = {STDERR_FILENO, POLLOUT, 0};  // a pipe that nobody reads would block
    if (poll(&err, 1, 0) == 1 && err.revents == POLLOUT)
      (void)!write(STDERR_FILENO, text.data(), text.size());
    _exit(kExitCancelled);
  }

  std::string tool_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

// Opens standard streams that the caller has closed, because the next file would take their
// numbers. Text for a closed stdout is an error; messages for a closed stderr are dropped.
void OpenStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && errno == EBADF)
      (void)!open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

// No log files. Of libraries only what ends the program is on stderr; GLOG_v in the environment
// asks for more.
void StartLogging(const char* program) {
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = FLAGS_v > 0 ? google::GLOG_INFO : google::GLOG_FATAL;
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

std::string running_tool;  // for OnTerminate

// Handles an exception that leaves a thread or a parallel region, which is nearly always bad_alloc.
[[noreturn]] void OnTerminate() {
  std::string reason = "ended without a reason";
  try {
    if (const std::exception_ptr error = std::current_exception()) std::rethrow_exception(error);
  } catch (const std::bad_alloc&) {
    reason = OutOfMemoryText();
  } catch (const std::exception& error) {
    reason = error.what();
  } catch (...) {
  }
  OutputFolder::Abandon();
  _exit(ReportError(running_tool, reason));
}

// "drape_fit" → "fit".
std::string ProgressName(const std::string& tool) {
  constexpr char kPrefix[] = "drape_";
  return tool.starts_with(kPrefix) ? tool.substr(sizeof kPrefix - 1) : tool;
}

ToolOutcome RunWithProgress(const std::string& tool,
                            const std::function<ToolOutcome(const RunControl&)>& run) {
  Progress progress(ProgressName(tool));
  std::mutex mutex;  // of the progress
  std::condition_variable_any changed;
  bool has_reported = false;
  // Shows that a run is alive that reads large files before its first report.
  const auto wait = [&](const std::stop_token& ended) {
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, ended, kReadingInterval, [&] { return has_reported; }) &&
           !ended.stop_requested())
      progress.Update(0.0, "reads its input");
  };
  std::jthread waiting;
  try {
    waiting = std::jthread(wait);
  } catch (const std::system_error&) {  // no more threads
  }
  return run({.cancel = &cancel_requested,
              .progress =
                  [&](double fraction, const std::string& note) {
                    const std::lock_guard lock(mutex);
                    has_reported = true;
                    progress.Update(fraction, note);
                  },
              .log =
                  [&](const std::string& line) {
                    const std::lock_guard lock(mutex);
                    progress.Say(line);
                  }});
}

ExitCode ReportOutcome(const std::string& tool, const ToolOutcome& outcome) {
  if (outcome.cancelled) return kExitCancelled;
  if (outcome.failure.empty()) return outcome.exit_code;
  std::fprintf(stderr, "%s: failed: %s\n", tool.c_str(),
               MakePrintableLine(outcome.failure).c_str());
  return kExitNumerical;
}

// Flushes both streams. Output that did not arrive is an error, which the other stream reports.
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
    std::shared_ptr<const StoredRun> repeated;
    RecordCommand(argc, argv);
    if (ParseCommandLine(table, argc, argv, &repeated) == ParseOutcome::kHelpShown) return kExitOk;
    RecordRunOptions(table, std::move(repeated));
    const ToolOutcome outcome = RunWithProgress(table.tool, run);
    run_has_ended = true;
    std::fputs(MakePrintable(outcome.text).c_str(), stdout);
    if (!outcome.next.empty() && !outcome.cancelled)
      std::printf("  %s\n", ShellLine(outcome.next).c_str());
    return ReportOutcome(table.tool, outcome);
  } catch (const std::bad_alloc&) {
    return ReportError(table.tool, OutOfMemoryText());
  } catch (const std::exception& error) {  // InputError, NotCompiled
    return ReportError(table.tool, error.what());
  }
}

fs::path FindScript(const std::string& installed, const std::string& source) {
  std::error_code ignored;
  const fs::path programs = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  fs::path shared = programs.parent_path() / "share/drapefit" / installed;
  if (fs::exists(shared, ignored)) return shared;
  for (fs::path folder = programs; folder.has_relative_path(); folder = folder.parent_path())
    if (fs::exists(folder / source, ignored)) return folder / source;
  return {};
}

// Keeps memory that is freed for the next use. Factors and Jacobians come and go with every pattern
// and rollout, and a fresh page of a virtual machine can cost more than the numbers in it.
void KeepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kNever = std::numeric_limits<int>::max(), kMore = 1 << 26;  // bytes
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, kNever);
  mallopt(M_TOP_PAD, kMore);
#endif
}

}  // namespace

std::vector<std::string> ScriptCommand(const std::string& installed, const std::string& source) {
  const fs::path debian = "/usr/bin/python3";
  std::error_code ignored;
  return {fs::exists(debian, ignored) ? debian.string() : "python3", "-B",
          FindScript(installed, source).string()};
}

int RunTool(int argc, char** argv, const OptionTable& table,
            const std::function<ToolOutcome(const RunControl& control)>& run) {
  OpenStandardStreams();
  KeepFreedMemory();
  const InterruptWatch watch(table.tool);
  running_tool = table.tool;
  std::set_terminate(OnTerminate);
  StartLogging(argv[0]);
  Eigen::setNbThreads(1);  // batches run in parallel instead, on --threads
  return CloseStreams(table.tool, Run(argc, argv, table, run));
}

}  // namespace drape
