// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <sstream>
#include <system_error>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/studies/optimisers/methods/optimiser.h"

namespace drape {
namespace {

// A process whose standard input and output are one socket: writing to a dead one gives an error
// instead of a signal. It is in a group of its own, out of reach of Ctrl-C.
class SearchProcess {
 public:
  explicit SearchProcess(std::vector<std::string> command) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw InputError(command.front(), "cannot start: " + std::system_category().message(errno));
    socket_ = ends[0];
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    std::vector<char*> words;
    for (std::string& word : command) words.push_back(word.data());
    words.push_back(nullptr);
    const int error = posix_spawnp(&pid_, words[0], &actions, &attributes, words.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (error == 0) return;
    close(socket_);
    throw InputError(command.front(), "cannot start: " + std::system_category().message(error));
  }
  ~SearchProcess() {
    kill(pid_, SIGKILL);
    close(socket_);
    if (!ended_) waitpid(pid_, nullptr, 0);
  }
  SearchProcess(const SearchProcess&) = delete;
  SearchProcess& operator=(const SearchProcess&) = delete;

  // Without its end; empty at the end of the output.
  std::string ReadLine() {
    std::string line;
    for (char c = 0; recv(socket_, &c, 1, 0) == 1 && c != '\n';) line += c;
    return line;
  }
  void Write(const std::string& line) const {
    [[maybe_unused]] const auto sent = send(socket_, line.data(), line.size(), MSG_NOSIGNAL);
  }
  // Waits for its end. False unless it ended with 0.
  bool Succeeds() {
    int status = 0;
    ended_ = waitpid(pid_, &status, 0) == pid_;
    return ended_ && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  pid_t pid_ = 0;
  int socket_ = -1;
  bool ended_ = false;
};

}  // namespace

std::string RunSearch(BudgetedFunction& function, const std::string& name,
                      const OptimiserOptions& options) {
  if (function.exhausted()) return "budget spent";
  MeteredCost cost(function);
  std::vector<std::string> command = options.search_command;
  command.insert(command.end(), {name, std::to_string(function.size()), Format("%.17g", kBound),
                                 std::to_string(options.seed)});
  SearchProcess search(command);
  Eigen::VectorXd theta(function.size());
  while (!function.exhausted()) {
    std::istringstream line(search.ReadLine());
    double seconds = 0.0;
    line >> seconds;
    for (double& value : theta) line >> value;
    if (!line) {
      if (search.Succeeds()) return "converged";
      throw InputError(
          "methods", "'" + name + "' ended early, expected numpy and scipy in " + command.front());
    }
    function.AddSeconds(seconds);
    const std::optional<double> found = cost.Evaluate(theta);
    search.Write(found ? Format("%.17g\n", *found) : "none\n");
  }
  return "budget spent";
}

}  // namespace drape
