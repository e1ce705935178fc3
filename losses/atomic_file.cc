// SPDX-License-Identifier: Apache-2.0
#include "losses/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "physics/errors.h"

namespace drape {
namespace {

// Opens a file of a name that did not exist; returns −1 with errno set on failure.
int OpenFresh(const std::string& path, std::string* fresh_path) {
  static std::atomic<int> counter{0};
  int descriptor;
  do {
    *fresh_path = path + ".tmp-" + std::to_string(getpid()) + "-" + std::to_string(counter++);
    descriptor = open(fresh_path->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EEXIST);
  return descriptor;
}

bool WriteAll(int descriptor, const std::vector<uint8_t>& bytes) {
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t count = write(descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno != EINTR) return false;
    if (count > 0) done += count;
  }
  return fsync(descriptor) == 0;
}

}  // namespace

void WriteFileAtomically(const std::string& path, const std::vector<uint8_t>& bytes) {
  std::string fresh_path;
  const int descriptor = OpenFresh(path, &fresh_path);
  if (descriptor < 0) {
    throw InputError(path, std::string("cannot be written: ") + std::strerror(errno));
  }
  int error = WriteAll(descriptor, bytes) ? 0 : errno;
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(fresh_path.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    unlink(fresh_path.c_str());
    throw InputError(path, std::string("cannot be written: ") + std::strerror(error));
  }
}

}  // namespace drape
