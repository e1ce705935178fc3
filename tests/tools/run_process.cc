// SPDX-License-Identifier: Apache-2.0
#include "tests/tools/run_process.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

namespace drape::test {
namespace {

// An unnamed file that collects an output stream.
class Capture {
 public:
  Capture() : file_(std::tmpfile()) { CHECK(file_ != nullptr); }
  ~Capture() { std::fclose(file_); }
  int descriptor() const { return fileno(file_); }
  std::string Text() const {
    std::rewind(file_);
    std::string text;
    for (int c; (c = std::fgetc(file_)) != EOF;) text += static_cast<char>(c);
    return text;
  }

 private:
  std::FILE* file_;
};

[[noreturn]] void Execute(const std::vector<std::string>& command, const ProcessLimits& limits,
                          const Capture& out, const Capture& err) {
  if (limits.file_bytes > 0) {
    const rlimit limit = {static_cast<rlim_t>(limits.file_bytes), RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (limits.address_bytes > 0) {
    const rlimit limit = {static_cast<rlim_t>(limits.address_bytes), RLIM_INFINITY};
    setrlimit(RLIMIT_AS, &limit);
  }
  if (!limits.folder.empty() && chdir(limits.folder.c_str()) != 0) _exit(126);
  for (const auto& [name, value] : limits.environment) setenv(name.c_str(), value.c_str(), 1);
  if (!limits.charts) setenv("PYTHONPATH", DRAPE_SOURCE_DIR "/tests/tools/without_charts", 1);
  const auto redirect = [](const std::string& file, const Capture& capture, int stream) {
    dup2(file.empty() ? capture.descriptor() : open(file.c_str(), O_WRONLY | O_CLOEXEC), stream);
  };
  redirect(limits.out_file, out, STDOUT_FILENO);
  redirect(limits.err_file, err, STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& part : command) arguments.push_back(const_cast<char*>(part.c_str()));
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

int WaitFor(pid_t child) {
  int status = 0;
  CHECK_EQ(waitpid(child, &status, 0), child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool IsReady(const ProcessLimits& limits) {
  if (!std::filesystem::exists(limits.interrupt_when)) return false;
  if (limits.interrupt_lines == 0) return true;
  std::ifstream file(limits.interrupt_when);
  const std::istreambuf_iterator<char> begin(file), end;
  return std::count(begin, end, '\n') >= limits.interrupt_lines;
}

void InterruptWhen(const ProcessLimits& limits, pid_t child) {
  using std::chrono::duration;
  constexpr int kMostTries = 30000;
  for (int i = 0; i < kMostTries && !IsReady(limits); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::this_thread::sleep_for(duration<double>(limits.interrupt_after));
  kill(child, limits.interrupt_signal);
}

}  // namespace

ProcessResult RunProcess(const std::vector<std::string>& command, const ProcessLimits& limits) {
  const Capture out, err;
  const pid_t child = fork();
  CHECK_GE(child, 0);
  if (child == 0) Execute(command, limits, out, err);
  if (!limits.interrupt_when.empty()) InterruptWhen(limits, child);
  return {WaitFor(child), out.Text(), err.Text()};
}

}  // namespace drape::test
