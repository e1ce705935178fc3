// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/front/child.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "physics/util/errors.h"

extern char** environ;

namespace drape {
namespace {

volatile std::sig_atomic_t running_child = 0;

extern "C" void PassOn(int signal) {
  if (running_child > 0) kill(static_cast<pid_t>(running_child), signal);
}

std::vector<char*> ListTexts(const std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (const std::string& text : texts) list.push_back(const_cast<char*>(text.c_str()));
  list.push_back(nullptr);
  return list;
}

}  // namespace

int RunAttached(const std::vector<std::string>& command) {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, PassOn);
  pid_t child = 0;
  const int error =
      posix_spawn(&child, command[0].c_str(), nullptr, nullptr, ListTexts(command).data(), environ);
  if (error != 0) throw InputError(command[0], std::string("cannot be run: ") + strerror(error));
  running_child = child;
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  running_child = 0;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_DFL);
  constexpr int kSignalled = 128;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status);
}

void Become(const std::string& path, const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {path};
  command.insert(command.end(), arguments.begin(), arguments.end());
  execv(path.c_str(), ListTexts(command).data());
  throw InputError(path, std::string("cannot be run: ") + strerror(errno));
}

}  // namespace drape
