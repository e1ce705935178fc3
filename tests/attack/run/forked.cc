// SPDX-License-Identifier: Apache-2.0
#include "tests/attack/run/forked.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>

#include "tests/attack/run/process.h"

namespace drape::attack {
namespace {

constexpr double kMemory = 4e9;  // bytes of address space of a child
// Records of the pipe: a byte, then a number or text, then NUL.
constexpr char kBegins = 'B', kReason = 'R';

void WriteRecord(int fd, char kind, const std::string& text) {
  const std::string record = kind + text + '\0';
  if (write(fd, record.data(), record.size()) != static_cast<ssize_t>(record.size())) _exit(3);
}

[[noreturn]] void RunChild(int fd, int first, int count,
                           const std::function<std::vector<std::string>(int)>& try_one) {
  const rlimit memory = {static_cast<rlim_t>(kMemory), static_cast<rlim_t>(kMemory)};
  if (kCanLimitMemory) setrlimit(RLIMIT_AS, &memory);
  const rlimit core = {0, 0};
  setrlimit(RLIMIT_CORE, &core);
  // The trace of a crash is known by its signal.
  const int null = open("/dev/null", O_WRONLY);
  dup2(null, STDERR_FILENO);
  for (int i = first; i < count; ++i) {
    WriteRecord(fd, kBegins, std::to_string(i));
    for (const std::string& reason : try_one(i)) WriteRecord(fd, kReason, reason);
  }
  _exit(0);
}

// What the child wrote so far.
class Log {
 public:
  Log(int first, std::vector<ForkedFailure>* failures) : current_(first), failures_(failures) {}

  int current() const { return current_; }
  void Add(const std::string& reason) {
    if (failures_->empty() || failures_->back().index != current_)
      failures_->push_back({current_, {}});
    failures_->back().reasons.push_back(reason);
  }
  void Read(const char* bytes, ssize_t size) {
    for (ssize_t i = 0; i < size; ++i) {
      if (bytes[i] != '\0') {
        record_ += bytes[i];
        continue;
      }
      if (record_.front() == kBegins) current_ = std::stoi(record_.substr(1));
      if (record_.front() == kReason) Add(record_.substr(1));
      record_.clear();
    }
  }

 private:
  int current_;
  std::string record_;
  std::vector<ForkedFailure>* failures_;
};

// Reads until the child ends or is silent for too long; false in that case.
bool ReadAll(int fd, double seconds, Log* log) {
  char buffer[4096];
  pollfd ready = {fd, POLLIN, 0};
  while (true) {
    if (poll(&ready, 1, static_cast<int>(1000 * seconds)) == 0) return false;
    const ssize_t size = read(fd, buffer, sizeof buffer);
    if (size <= 0) return true;
    log->Read(buffer, size);
  }
}

}  // namespace

std::vector<ForkedFailure> TryForked(int count, double seconds,
                                     const std::function<std::vector<std::string>(int)>& try_one) {
  std::vector<ForkedFailure> failures;
  for (int first = 0; first < count;) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("cannot make a pipe");
    const pid_t pid = fork();
    if (pid < 0) throw std::runtime_error("cannot start a process");
    if (pid == 0) RunChild(ends[1], first, count, try_one);
    close(ends[1]);
    Log log(first, &failures);
    const bool ended = ReadAll(ends[0], seconds, &log);
    close(ends[0]);
    if (!ended) kill(pid, SIGKILL);
    int status = 0;
    waitpid(pid, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) break;
    if (!ended)
      log.Add("did not end");
    else if (WIFSIGNALED(status))
      log.Add(std::string("was ended by ") + strsignal(WTERMSIG(status)));
    else
      log.Add("ended the process with exit code " + std::to_string(WEXITSTATUS(status)));
    first = log.current() + 1;
  }
  return failures;
}

}  // namespace drape::attack
