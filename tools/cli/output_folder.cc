// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/output_folder.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

// Guards the list of folders of this process and their publication.
std::mutex live_mutex;
std::atomic<bool> any_published = false;
std::set<const OutputFolder*>& LiveFolders() {
  static std::set<const OutputFolder*> folders;
  return folders;
}

[[noreturn]] void FailToWrite(const std::string& path, const std::string& reason) {
  throw IoError(path, "cannot write to the output folder: " + reason);
}

}  // namespace

OutputFolder::OutputFolder(std::string path, const std::vector<std::string>& names, Use use)
    : path_(std::move(path)) {
  std::error_code error;
  made_ = fs::create_directories(path_, error);
  if (!error && !fs::is_directory(path_)) error = std::make_error_code(std::errc::not_a_directory);
  if (error) FailToWrite(path_, error.message());
  Lock(use);
  try {
    CheckKeeps(path_ + "/summary.json");
    for (const std::string& file : names) {
      CheckKeeps(path_ + "/" + file);
      CheckReplaceable(path_ + "/" + file);
    }
  } catch (...) {
    Drop();
    close(lock_);
    throw;
  }
  if (use == Use::kAlone) MakeStaging();
  const std::lock_guard guard(live_mutex);
  LiveFolders().insert(this);
}

void OutputFolder::MakeStaging() {
  RemoveTemporaries(path_, 1);
  staging_ = path_ + "/" + TemporaryName();
  constexpr mode_t kOwner = 0700;
  if (mkdir(staging_.c_str(), kOwner) != 0) {
    const int reason = errno;
    staging_.clear();
    Drop();
    close(lock_);
    FailToWrite(path_, std::strerror(reason));
  }
  staging_lock_ = open(staging_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  flock(staging_lock_, LOCK_EX | LOCK_NB);  // it is in use
}

OutputFolder::~OutputFolder() {
  const std::lock_guard guard(live_mutex);
  LiveFolders().erase(this);
  Drop();
  if (staging_lock_ >= 0) close(staging_lock_);
  close(lock_);
}

// A lock of the folder itself needs no file and ends with the process; processes of other
// containers see it too.
void OutputFolder::Lock(Use use) {
  lock_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) FailToWrite(path_, std::strerror(errno));
  const int kind = use == Use::kAlone ? LOCK_EX : LOCK_SH;
  if (flock(lock_, kind | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;  // or has no locks
  close(lock_);
  throw InputError(path_,
                   "another program is writing to this folder, expected one of its own for each "
                   "run");
}

void OutputFolder::Drop() const {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
  if (made_) fs::remove(path_, ignored);  // only when it is empty
}

void OutputFolder::Publish() const {
  CHECK(!staging_.empty()) << "a shared folder has nothing to publish";
  const std::lock_guard guard(live_mutex);
  std::vector<std::string> names;
  for (const fs::directory_entry& file : fs::directory_iterator(staging_)) {
    names.push_back(file.path().filename().string());
    const std::string target = path_ + "/" + names.back();
    if (fs::is_directory(fs::symlink_status(target)))
      throw IoError(target, "cannot replace the file: a folder is in its place");
    CheckKeeps(target);
  }
  std::sort(names.begin(), names.end());
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return name != "summary.json"; });
  for (const std::string& name : names) {
    std::error_code error;
    fs::rename(Staged(name), path_ + "/" + name, error);
    if (error) throw IoError(path_ + "/" + name, "cannot replace the file: " + error.message());
  }
  any_published = true;
}

bool OutputFolder::IsAnyOpen() {
  const std::unique_lock guard(live_mutex, std::try_to_lock);
  return !guard || !LiveFolders().empty();
}

bool OutputFolder::HasAnyPublished() { return any_published; }

void OutputFolder::Abandon() {
  live_mutex.lock();  // for good
  AbandonTemporaries();
  for (const OutputFolder* folder : LiveFolders()) folder->Drop();
}

}  // namespace drape
