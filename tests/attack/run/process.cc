// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/run/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace drape::attack {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kGigabyte = 1e9;

// Closed by its end.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {
    if (fd_ < 0) throw std::runtime_error(std::string("cannot open: ") + std::strerror(errno));
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(fd_); }
  int get() const { return fd_; }

 private:
  int fd_;
};

// Where a stream of the program goes: its descriptor, and the text that arrived there.
class Sink {
 public:
  explicit Sink(Stream kind) : kind_(kind), fd_(Open(kind)) {}
  bool closed() const { return kind_ == Stream::kClosed; }
  int descriptor() const { return fd_.get(); }
  std::string Text() const {
    if (kind_ != Stream::kFile) return "";
    std::string text;
    lseek(fd_.get(), 0, SEEK_SET);
    char buffer[4096];
    for (ssize_t n; (n = read(fd_.get(), buffer, sizeof buffer)) > 0;) text.append(buffer, n);
    return text;
  }

 private:
  static int Open(Stream kind) {
    if (kind == Stream::kFull) return open("/dev/full", O_WRONLY | O_CLOEXEC);
    if (kind == Stream::kClosed) return open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (kind == Stream::kBroken || kind == Stream::kStuck) {
      int ends[2];
      if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return -1;
      if (kind == Stream::kBroken) close(ends[0]);  // the other reading end stays open
      while (kind == Stream::kStuck && write(ends[1], "\n", 1) == 1) {
      }
      fcntl(ends[1], F_SETFL, 0);
      return ends[1];
    }
    return memfd_create("stream", MFD_CLOEXEC);
  }

  Stream kind_;
  Descriptor fd_;
};

// argv or envp of execve; the texts outlive it.
std::vector<char*> Pointers(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> MakeEnvironment(const Request& request) {
  std::vector<std::string> all;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    if (!request.environment.contains(text.substr(0, text.find('=')))) all.push_back(text);
  }
  for (const auto& [key, value] : request.environment)
    if (value) all.push_back(key + "=" + *value);
  return all;
}

void Limit(decltype(RLIMIT_AS) resource, double amount) {
  if (amount <= 0) return;
  const rlimit limit = {static_cast<rlim_t>(amount), static_cast<rlim_t>(amount)};
  setrlimit(resource, &limit);
}

// Between fork and exec only what is safe after a fork of a program with threads.
struct Child {
  const char* folder;
  char* const* argv;
  char* const* envp;
  const Request& request;
  const Sink& out;
  const Sink& err;

  [[noreturn]] void Execute() const {
    setpgid(0, 0);
    for (const int number : {SIGINT, SIGTERM, SIGPIPE}) signal(number, SIG_DFL);
    const Limits& limits = request.limits;
    rlimit core = {0, 0};
    setrlimit(RLIMIT_CORE, &core);
    if (kCanLimitMemory) Limit(RLIMIT_AS, limits.memory_gb * kGigabyte);
    Limit(RLIMIT_FSIZE, static_cast<double>(limits.file_bytes));
    Limit(RLIMIT_CPU, limits.processor_seconds);
    if (chdir(folder) != 0) _exit(126);
    dup2(out.descriptor(), STDOUT_FILENO);
    dup2(err.descriptor(), STDERR_FILENO);
    if (out.closed()) close(STDOUT_FILENO);
    if (err.closed()) close(STDERR_FILENO);
    if (!request.input) close(STDIN_FILENO);
    Limit(RLIMIT_NOFILE, limits.files);
    execve(argv[0], argv, envp);
    _exit(127);
  }
};

// Processor time of a process and its threads so far [s].
double ProcessorSeconds(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
  std::string skipped;
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

// Threads of the machine that run or wait to run, for each processor.
double WaitingPerCore() {
  std::string text;
  std::ifstream file("/proc/loadavg");
  for (int i = 0; i < 4; ++i) file >> text;  // "2/345" is the fourth
  return std::atof(text.c_str()) / std::max(1u, std::thread::hardware_concurrency());
}

// Returns whether a process has a handler of the signal, or blocks it for a thread that waits.
bool Catches(pid_t pid, int signal) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  unsigned long long caught = 0;
  for (std::string line; std::getline(status, line);)
    for (const char* masks : {"SigCgt:\t", "SigBlk:\t"})
      if (line.rfind(masks, 0) == 0) caught |= std::stoull(line.substr(8), nullptr, 16);
  return (caught >> (signal - 1) & 1) != 0;
}

std::string ThreadStates(pid_t pid) {
  std::ostringstream text;
  std::error_code ignored;
  const std::string tasks = "/proc/" + std::to_string(pid) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks, ignored))
    for (const char* name : {"/wchan", "/stack", "/status"})
      text << task.path().string() << name << ":\n"
           << std::ifstream(task.path().string() + name).rdbuf() << "\n";
  return text.str();
}

// Waits, sends what the request says, and ends what does not end by itself.
class Watch {
 public:
  Watch(pid_t pid, const Request& request) : pid_(pid), request_(request) {}

  int Wait(Outcome* outcome) {
    int status = 0;
    double pause = 1e-3;
    while (waitpid(pid_, &status, WNOHANG) == 0) {
      std::this_thread::sleep_for(std::chrono::duration<double>(pause));
      pause = std::min(1.2 * pause, 0.02);
      Act(outcome);
    }
    outcome->seconds = SecondsSince(start_);
    if (signalled_at_ > 0) outcome->answer_seconds = outcome->seconds - signalled_at_;
    if (polls_ > 0) outcome->waiting_per_core = waiting_ / polls_;
    return status;
  }

 private:
  void Act(Outcome* outcome) {
    const double seconds = SecondsSince(start_);
    const Limits& limits = request_.limits;
    const Signal& signal = request_.signal;
    if (signalled_at_ > 0) {
      waiting_ += WaitingPerCore();
      ++polls_;
      if (signal.patience > 0 && seconds - signalled_at_ > signal.patience && !outcome->hung) {
        outcome->threads = ThreadStates(pid_);
        outcome->hung = true;
        kill(-pid_, SIGKILL);
      }
    } else if (signal.number != 0 && seconds >= signal.after) {
      outcome->was_caught = Catches(pid_, signal.number);
      signalled_at_ = SecondsSince(start_);
      kill(pid_, signal.number);
    }
    if (!outcome->cancelled && seconds >= test::kSlowdown * limits.seconds) {
      outcome->cancelled = true;
      cancelled_at_ = seconds;
      processor_then_ = ProcessorSeconds(pid_);
      kill(pid_, SIGINT);
    }
    if (!outcome->cancelled || outcome->hung) return;
    // On a busy machine a program may get little of the time.
    constexpr double kBusy = 8.0;
    const double used = ProcessorSeconds(pid_) - processor_then_;
    if (used < limits.seconds_after_signal &&
        seconds - cancelled_at_ < kBusy * limits.seconds_after_signal)
      return;
    outcome->hung = true;
    kill(-pid_, SIGKILL);
  }

  pid_t pid_;
  const Request& request_;
  const Clock::time_point start_ = Clock::now();
  double signalled_at_ = 0.0, waiting_ = 0.0;
  int polls_ = 0;
  double cancelled_at_ = 0.0, processor_then_ = 0.0;
};

bool IsPlain(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) || std::strchr("_-./=,:+", c) != nullptr;
  });
}

std::string RedirectText(const std::string& descriptor, Stream stream) {
  if (stream == Stream::kClosed) return " " + descriptor + ">&-";
  if (stream == Stream::kFull) return " " + descriptor + ">/dev/full";
  if (stream == Stream::kStuck) return " " + descriptor + "> >(sleep 60)";
  return "";
}

}  // namespace

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Outcome RunProgramIn(const std::string& folder, const Request& request) {
  const Sink out(request.out), err(request.err);
  const std::vector<std::string> environment = MakeEnvironment(request);
  const std::vector<char*> argv = Pointers(request.command), envp = Pointers(environment);
  const Child child{folder.c_str(), argv.data(), envp.data(), request, out, err};
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("cannot start a process");
  if (pid == 0) child.Execute();
  setpgid(pid, pid);
  Outcome outcome;
  const int status = Watch(pid, request).Wait(&outcome);
  // A child that the system ends with its parent takes a moment.
  for (int i = 0; i < 50 && kill(-pid, 0) == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  outcome.left_process = kill(-pid, SIGKILL) == 0 && !outcome.hung;
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  outcome.out = out.Text();
  outcome.err = err.Text();
  return outcome;
}

std::string ShellWord(const std::string& text) {
  if (IsPlain(text)) return text;
  std::string word = "$'";
  for (const unsigned char c : text) {
    if (c == '\'' || c == '\\') {
      word += '\\';
      word += static_cast<char>(c);
    } else if (c < 0x20 || c >= 0x7f) {
      char octal[5];
      std::snprintf(octal, sizeof octal, "\\%03o", c);
      word += octal;
    } else {
      word += static_cast<char>(c);
    }
  }
  return word + "'";
}

std::string ShellLine(const Request& request) {
  std::string line = "(";
  const Limits& limits = request.limits;
  const auto add_limit = [&](const std::string& flag, double value) {
    if (value > 0)
      line += "ulimit -" + flag + " " + std::to_string(static_cast<long>(value)) + "; ";
  };
  add_limit("v", limits.memory_gb * kGigabyte / 1024);
  add_limit("f", std::max(limits.file_bytes / 1024.0, limits.file_bytes > 0 ? 1.0 : 0.0));
  add_limit("n", limits.files);
  add_limit("t", limits.processor_seconds);
  line += "env";
  for (const auto& [key, value] : request.environment)
    line += value ? " " + key + "=" + ShellWord(*value) : " -u " + key;
  if (request.signal.number != 0)
    line += " timeout -s " + std::to_string(request.signal.number) + " " +
            std::to_string(request.signal.after);
  for (const std::string& word : request.command) line += " " + ShellWord(word);
  if (!request.input) line += " <&-";
  return line + RedirectText("1", request.out) + RedirectText("2", request.err) +
         (request.out == Stream::kBroken ? " | true" : "") + ")";
}

}  // namespace drape::attack
