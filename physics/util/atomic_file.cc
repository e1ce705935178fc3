// SPDX-License-Identifier: Apache-2.0
#include "physics/util/atomic_file.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "physics/util/errors.h"

namespace drape {
namespace {

// A temporary file beside `path`. The destructor removes it unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& path) : path_(path), temporary_(UniqueName(path)) {
    errno = 0;
    out_.open(temporary_, std::ios::binary | std::ios::trunc);
    if (!out_) Fail("cannot create a file in this folder");
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    if (!renamed_) std::filesystem::remove(temporary_, ignored);
  }

  std::ostream& out() { return out_; }

  void Rename() {
    errno = 0;
    out_.close();  // flushes; fails when the disk is full
    if (!out_ || !FlushToDisk()) Fail("cannot write the whole file");
    std::error_code error;
    std::filesystem::rename(temporary_, path_, error);
    if (error) throw InputError(path_, "cannot replace the file: " + error.message());
    renamed_ = true;
  }

 private:
  static std::string UniqueName(const std::string& path) {
    static std::atomic<int> counter = 0;
    return path + ".tmp." + std::to_string(getpid()) + "." + std::to_string(counter++);
  }

  // Without the flush, a crash of the machine may keep the new name and lose the content.
  bool FlushToDisk() const {
    const int file = open(temporary_.c_str(), O_WRONLY | O_CLOEXEC);
    const bool flushed = file >= 0 && fsync(file) == 0;
    if (file >= 0) close(file);
    return flushed;
  }

  [[noreturn]] void Fail(const std::string& problem) const {
    const std::string reason = errno != 0 ? std::string(": ") + std::strerror(errno) : "";
    throw InputError(path_, problem + reason);
  }

  std::string path_, temporary_;
  std::ofstream out_;
  bool renamed_ = false;
};

}  // namespace

void WriteFileAtomically(const std::string& path,
                         const std::function<void(std::ostream&)>& writer) {
  TemporaryFile file(path);
  writer(file.out());
  file.Rename();
}

void WriteFileAtomically(const std::string& path, std::string_view content) {
  WriteFileAtomically(path, [content](std::ostream& out) {
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
  });
}

std::string ReadWholeFile(const std::string& path) {
  if (!std::filesystem::exists(path)) throw InputError(path, "no such file");
  if (std::filesystem::is_directory(path)) {
    throw InputError(path, "is a folder, expected a file");
  }
  std::ifstream in(path, std::ios::binary);
  std::ostringstream content;
  if (in.peek() != std::ifstream::traits_type::eof()) content << in.rdbuf();
  if (in.bad() || (!in.is_open())) throw InputError(path, "cannot read the file");
  return std::move(content).str();
}

void AppendNumber(std::string& text, double value) {
  CHECK(std::isfinite(value)) << "a number to be written is " << value;
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  text.append(buffer, end);
}

}  // namespace drape
