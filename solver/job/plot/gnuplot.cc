// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/gnuplot.h"

#include <spawn.h>
#include <sys/wait.h>

#include <cstdio>
#include <memory>

#include "physics/util/errors.h"

extern char** environ;

namespace drape {
namespace {

// Unnamed, gone when closed.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& content = "") : file_(std::tmpfile(), &std::fclose) {
    if (!file_ || std::fwrite(content.data(), 1, content.size(), file_.get()) != content.size() ||
        std::fflush(file_.get()) != 0)
      throw InputError("gnuplot", "no space for temporary files");
    std::rewind(file_.get());
  }
  int descriptor() const { return fileno(file_.get()); }
  std::string Content() const {
    std::string content;
    std::rewind(file_.get());
    char piece[4096];
    while (const std::size_t n = std::fread(piece, 1, sizeof piece, file_.get()))
      content.append(piece, n);
    return content;
  }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

std::string FirstLine(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \n\t^");
  return begin == std::string::npos ? "" : text.substr(begin, text.find('\n', begin) - begin);
}

}  // namespace

std::string RunGnuplot(const std::string& script) {
  const ScratchFile in(script), out, complaints;
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, in.descriptor(), 0);
  posix_spawn_file_actions_adddup2(&files, out.descriptor(), 1);
  posix_spawn_file_actions_adddup2(&files, complaints.descriptor(), 2);
  char name[] = "gnuplot";
  char* const arguments[] = {name, nullptr};
  pid_t process = 0;
  const int refused = posix_spawnp(&process, name, &files, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&files);
  if (refused != 0) throw InputError("gnuplot", "cannot be started, expected it to be installed");
  int status = 0;
  waitpid(process, &status, 0);
  if (status != 0) throw InputError("gnuplot", FirstLine(complaints.Content()));
  return out.Content();
}

}  // namespace drape
