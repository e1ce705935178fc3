// SPDX-License-Identifier: Apache-2.0
#include "physics/util/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <regex>
#include <set>
#include <stdexcept>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/math/sha256.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// ": No space left on device"; empty without an error.
std::string Reason(int error) { return error == 0 ? "" : std::string(": ") + std::strerror(error); }

// Writes as much of the text as the system takes and returns the number of bytes; errno is 0 or
// says what ended it.
std::size_t WriteBytes(int descriptor, std::string_view text) noexcept {
  std::size_t written = 0;
  errno = 0;
  while (written < text.size()) {
    const ssize_t count = write(descriptor, text.data() + written, text.size() - written);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    written += static_cast<std::size_t>(count);
  }
  return written;
}

// Guards the names of this process's temporary files, and their beginning and end.
std::mutex temporaries_mutex;
std::set<std::string>& Temporaries() {
  static std::set<std::string> names;
  return names;
}

// A new file of an unguessable name beside `path`. The destructor removes it unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& path) : path_(path), temporary_(UniqueName(path)) {
    const std::lock_guard guard(temporaries_mutex);
    descriptor_ =
        open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor_ < 0) Fail("cannot create a file in this folder", errno);
    flock(descriptor_, LOCK_EX | LOCK_NB);  // it is in use
    Temporaries().insert(temporary_);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    const std::lock_guard guard(temporaries_mutex);
    close(descriptor_);
    if (!renamed_) unlink(temporary_.c_str());
    Temporaries().erase(temporary_);
  }

  void Write(std::string_view content) {
    const std::size_t written = WriteBytes(descriptor_, content);
    // Without fsync, a crash of the machine may keep the new name and lose the content.
    if (written < content.size() || fsync(descriptor_) != 0)
      Fail("cannot write the whole file, only " + std::to_string(written) + " bytes", errno);
  }
  void Rename() {
    const std::lock_guard guard(temporaries_mutex);
    std::error_code error;
    fs::rename(temporary_, path_, error);
    if (error) throw IoError(path_, "cannot replace the file: " + error.message());
    renamed_ = true;
  }

 private:
  static std::string UniqueName(const std::string& path) {
    return (fs::path(path).parent_path() / TemporaryName()).string();
  }

  [[noreturn]] void Fail(const std::string& problem, int error) const {
    throw IoError(path_, problem + Reason(error));
  }

  std::string path_, temporary_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

// Opens a file to append to it; `flags` besides. -1 where there is none.
int OpenRegular(const std::string& path, int flags) {
  // A pipe without a reader would block.
  const int descriptor =
      open(path.c_str(), O_WRONLY | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | flags, 0666);
  if (descriptor < 0 && errno == ENOENT && (flags & O_CREAT) == 0) return -1;
  if (descriptor < 0 && errno == ELOOP)
    throw IoError(path, "is a link, expected a file or nothing");
  if (descriptor < 0 && errno == EISDIR)
    throw IoError(path, "is a folder, expected a file or nothing");
  if (descriptor < 0 && errno != ENXIO) throw IoError(path, "cannot be written" + Reason(errno));
  struct stat status = {};
  if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) return descriptor;
  if (descriptor >= 0) close(descriptor);
  throw IoError(path, "is not a regular file, expected one or nothing");
}

struct Descriptor {
  ~Descriptor() {
    if (value >= 0) close(value);
  }
  const int value;
};

// Opens a file without waiting, as for the other end of a pipe.
int OpenAtOnce(const std::string& path, int flags) {
  return open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | flags);
}

std::function<void(const std::string& path, std::string_view content)>& ReadObserver() {
  static std::function<void(const std::string&, std::string_view)> observer;
  return observer;
}

}  // namespace

void WriteFileAtomically(const std::string& path, std::string_view content) {
  CheckNameLength(path, fs::path(path).filename().string());
  TemporaryFile file(path);
  file.Write(content);
  file.Rename();
}

void AbandonTemporaries() {
  temporaries_mutex.lock();  // for good
  for (const std::string& name : Temporaries()) unlink(name.c_str());
}

void CheckReplaceable(const std::string& path) {
  CheckNameLength(path, fs::path(path).filename().string());
  std::error_code ignored;
  if (fs::is_directory(fs::symlink_status(path, ignored)))
    throw IoError(path, "is a folder, expected a file or nothing");
  const TemporaryFile file(path);  // rights alone do not tell, as in /proc
}

void CheckNameLength(const std::string& source, const std::string& name) {
  if (name.size() > NAME_MAX)
    throw InputError(source, "found a name of " + std::to_string(name.size()) +
                                 " bytes for a file, expected at most " + std::to_string(NAME_MAX));
}

std::string TemporaryName() {
  std::uint64_t number = 0;
  if (getrandom(&number, sizeof number, 0) != sizeof number)
    throw std::runtime_error("the system gives no random numbers");
  return Format(".drapefit_%016llx.tmp", static_cast<unsigned long long>(number));
}

void RemoveTemporaries(const std::string& folder, int levels) {
  static const std::regex kOurs(R"(\.drapefit_[0-9a-f]{16}\.tmp)");
  std::error_code error, ignored;
  std::vector<fs::path> left;
  const auto options = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator entry(folder, options, error), end; !error && entry != end;
       entry.increment(error)) {
    const bool is_ours = std::regex_match(entry->path().filename().string(), kOurs);
    if (is_ours || entry.depth() + 1 >= levels) entry.disable_recursion_pending();
    const Descriptor file{is_ours ? OpenAtOnce(entry->path(), O_NOFOLLOW) : -1};
    if (file.value >= 0 && flock(file.value, LOCK_EX | LOCK_NB) == 0) left.push_back(entry->path());
  }
  for (const fs::path& path : left) fs::remove_all(path, ignored);
}

AppendFile::AppendFile(const std::string& path, Content content)
    : descriptor_(OpenRegular(path, O_CREAT | (content == Content::kDrop ? O_TRUNC : 0))) {}

AppendFile::~AppendFile() { close(descriptor_); }

void AppendFile::Check(const std::string& path) {
  CheckReplaceable(path);
  if (const int descriptor = OpenRegular(path, 0); descriptor >= 0) close(descriptor);
}

bool AppendFile::TryAppend(std::string_view text) noexcept {
  return WriteBytes(descriptor_, text) == text.size();
}

void ObserveReads(std::function<void(const std::string& path, std::string_view content)> observer) {
  ReadObserver() = std::move(observer);
}

// The innermost record of the thread.
thread_local ReadRecord* read_record = nullptr;

ReadRecord::ReadRecord() : outer_(std::exchange(read_record, this)) {}
ReadRecord::~ReadRecord() { read_record = outer_; }

void ReadRecord::Add(const File& file) {
  for (ReadRecord* record = read_record; record != nullptr; record = record->outer_)
    record->files_.push_back(file);
}

std::string ReadWholeFile(const std::string& path, const std::string& part) {
  std::string content = ReadOwnFile(path);
  if (read_record != nullptr) ReadRecord::Add({path, Sha256(content) + part});
  if (const auto& observer = ReadObserver()) observer(path, content);
  return content;
}

std::string ReadOwnFile(const std::string& path) {
  constexpr std::size_t kLargest = std::size_t{1} << 30, kBlock = std::size_t{1} << 16;
  const Descriptor file{OpenAtOnce(path, 0)};
  if (file.value < 0 && (errno == ENOENT || errno == ENOTDIR))
    throw InputError(path, "no such file");
  struct stat status = {};
  if (file.value < 0 || fstat(file.value, &status) != 0)
    throw IoError(path, "cannot read the file" + Reason(errno));
  if (!S_ISREG(status.st_mode))
    throw InputError(path, std::string(S_ISDIR(status.st_mode)    ? "is a folder"
                                       : S_ISFIFO(status.st_mode) ? "is a pipe"
                                                                  : "is a device") +
                               ", expected a file");
  std::string content;
  for (ssize_t count = 1; count != 0 && content.size() <= kLargest;) {
    const std::size_t size = content.size();
    content.resize(size + kBlock);
    count = read(file.value, content.data() + size, kBlock);
    if (count < 0 && errno != EINTR) throw IoError(path, "cannot read the file" + Reason(errno));
    content.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  }
  if (content.size() > kLargest) throw InputError(path, "is larger than 1 GiB, expected less");
  return content;
}

std::vector<std::string> SplitPaths(const std::string& list) {
  constexpr int kMostCommas = 16;  // within one name, so that long lists take no time
  std::vector<std::string> paths;
  std::error_code ignored;
  for (std::size_t begin = 0; begin < list.size();) {
    std::size_t end = std::min(list.find(',', begin), list.size()), longer = end;
    for (int commas = 0; commas < kMostCommas && longer < list.size(); ++commas) {
      longer = std::min(list.find(',', longer + 1), list.size());
      if (fs::exists(list.substr(begin, longer - begin), ignored)) end = longer;
    }
    paths.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return paths;
}

void AppendNumber(std::string& text, double value) {
  if (!std::isfinite(value))
    throw std::domain_error("a number to be written to a file is not finite");
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  text.append(buffer, end);
}

}  // namespace drape
