// SPDX-License-Identifier: Apache-2.0
#include "physics/util/child_process.h"

#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <stdexcept>
#include <thread>

#include "physics/util/errors.h"

namespace drape {
namespace {

constexpr char kDone = 'd', kBadInput = 'i', kFailed = 'f';  // first byte of what a child says
constexpr int kPollMilliseconds = 100;
constexpr double kBytesPerUnit = 1024.0;  // ru_maxrss is in KiB

void WriteAll(int descriptor, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t written = write(descriptor, text.data() + at, text.size() - at);
    if (written <= 0) _exit(1);
    at += static_cast<std::size_t>(written);
  }
}

// What a child said, as its exception said it: "where: problem".
[[noreturn]] void ThrowInputError(const std::string& line) {
  const std::size_t colon = line.find(": ");
  if (colon == std::string::npos) throw InputError("child process", line);
  throw InputError(line.substr(0, colon), line.substr(colon + 2));
}

[[noreturn]] void RunChild(int descriptor, const std::function<std::string()>& work) {
  try {
    WriteAll(descriptor, kDone + work());
  } catch (const InputError& error) {
    WriteAll(descriptor, kBadInput + std::string(error.what()));
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

ChildResult RunInChild(const std::function<std::string()>& work, const std::atomic<bool>* cancel) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe to a child process");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process can be started");
  if (child == 0) {
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
  int status = 0;
  wait4(child, &status, 0, &used);
  if (result.cancelled) return result;
  if (status != 0 || result.output.empty())
    throw std::runtime_error("a child process died (out of memory?)");
  const char kind = result.output[0];
  result.output.erase(0, 1);
  if (kind == kBadInput) ThrowInputError(result.output);
  if (kind == kFailed) throw std::runtime_error(result.output);
  result.peak_bytes = kBytesPerUnit * static_cast<double>(used.ru_maxrss);
  return result;
}

}  // namespace drape
