// SPDX-License-Identifier: Apache-2.0
#include "physics/util/child_process.h"

#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <thread>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"

namespace drape {
namespace {

// A file in memory, which needs no folder for temporary files; gone when closed.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("drape", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw std::runtime_error("no memory for the files of a child process");
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }
  std::string Content() const {
    std::string content;
    char piece[65536];
    for (ssize_t got; (got = pread(descriptor_, piece, sizeof piece, off_t(content.size()))) > 0;)
      content.append(piece, static_cast<std::size_t>(got));
    return content;
  }

 private:
  int descriptor_;
};

// As the system takes them, with a null pointer at the end.
std::vector<char*> ListTexts(const std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (const std::string& text : texts) list.push_back(const_cast<char*>(text.c_str()));
  list.push_back(nullptr);
  return list;
}

// The status of the child once it has ended.
int WaitFor(pid_t child, rusage* used) {
  int status = 0;
  while (wait4(child, &status, 0, used) < 0 && errno == EINTR) {
  }
  return status;
}

constexpr int kCannotStart = 127;  // exit code of a program, as of a shell

// A child would outlive a parent that is killed, and keep its locks.
void EndWithParent(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
}

constexpr char kDone = 'd', kBadInput = 'i', kRefused = 'r',
               kFailed = 'f';  // first byte of a child's answer
constexpr int kPollMilliseconds = 100;
constexpr double kBytesPerUnit = 1024.0;  // ru_maxrss is in KiB

void WriteAll(int descriptor, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t written = write(descriptor, text.data() + at, text.size() - at);
    if (written <= 0) _exit(1);
    at += static_cast<std::size_t>(written);
  }
}

// Throws the error that a child reported as "where: problem".
template <class Error>
[[noreturn]] void ThrowAgain(const std::string& line) {
  const std::size_t colon = line.find(": ");
  if (colon == std::string::npos) throw Error("child process", line);
  throw Error(line.substr(0, colon), line.substr(colon + 2));
}

[[noreturn]] void RunChild(int descriptor, const std::function<std::string()>& work) {
  try {
    WriteAll(descriptor, kDone + work());
  } catch (const InputError& error) {
    WriteAll(descriptor, kBadInput + std::string(error.what()));
  } catch (const IoError& error) {
    WriteAll(descriptor, kRefused + std::string(error.what()));
  } catch (const std::exception& error) {
    WriteAll(descriptor, kFailed + std::string(error.what()));
  }
  _exit(0);
}

// Until the child closes its end or *cancel turns true, which it reports.
bool ReadAll(int descriptor, const std::atomic<bool>* cancel, std::string* text) {
  pollfd wait = {descriptor, POLLIN, 0};
  char piece[65536];
  while (cancel == nullptr || !*cancel) {
    if (poll(&wait, 1, kPollMilliseconds) <= 0) continue;
    const ssize_t got = read(descriptor, piece, sizeof piece);
    if (got <= 0) return true;
    text->append(piece, static_cast<std::size_t>(got));
  }
  return false;
}

}  // namespace

pid_t StartProgram(const std::vector<std::string>& arguments, int in, int out, int errors) {
  const std::vector<char*> texts = ListTexts(arguments);
  const pid_t parent = getpid(), child = fork();
  if (child < 0) throw std::runtime_error("no child process can be started");
  if (child > 0) return child;
  EndWithParent(parent);
  setpgid(0, 0);
  if (dup2(in, STDIN_FILENO) < 0 || dup2(out, STDOUT_FILENO) < 0 || dup2(errors, STDERR_FILENO) < 0)
    _exit(kCannotStart);
  close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);  // sockets of a server, say
  sigset_t none;  // the signals that this process blocks, it blocks for itself alone
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execvp(texts[0], texts.data());
  _exit(kCannotStart);
}

ProgramResult RunProgram(const std::vector<std::string>& arguments) {
  const MemoryFile in, out, errors;
  const int status = WaitFor(
      StartProgram(arguments, in.descriptor(), out.descriptor(), errors.descriptor()), nullptr);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kCannotStart)
    throw InputError(arguments[0], "cannot be started, expected it to be installed");
  return {status, out.Content(), errors.Content()};
}

ChildResult RunInChild(const std::function<std::string()>& work, const std::atomic<bool>* cancel) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe to a child process");
  const pid_t parent = getpid(), child = fork();
  if (child < 0) throw std::runtime_error("no child process can be started");
  if (child == 0) {
    EndWithParent(parent);
    close(ends[0]);
    // Threads do not survive a fork, and OpenMP would wait for those of the thread that forked. A
    // new thread starts its own.
    std::thread([&] { RunChild(ends[1], work); }).join();
  }
  close(ends[1]);
  ChildResult result;
  result.cancelled = !ReadAll(ends[0], cancel, &result.output);
  close(ends[0]);
  if (result.cancelled) kill(child, SIGKILL);
  rusage used = {};
  const int status = WaitFor(child, &used);
  if (result.cancelled) return result;
  if (status != 0 || result.output.empty())
    throw std::runtime_error("a child process died (out of memory?)");
  const char kind = result.output[0];
  result.output.erase(0, 1);
  if (kind == kBadInput) ThrowAgain<InputError>(result.output);
  if (kind == kRefused) ThrowAgain<IoError>(result.output);
  if (kind == kFailed) throw std::runtime_error(result.output);
  result.peak_bytes = kBytesPerUnit * static_cast<double>(used.ru_maxrss);
  return result;
}

}  // namespace drape
