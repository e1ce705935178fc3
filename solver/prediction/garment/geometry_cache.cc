// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/geometry_cache.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kSignature[12] = "POINTCACHE2";
constexpr int32_t kVersion = 1;

struct Header {
  char signature[12];
  int32_t version;
  int32_t points;
  float start, rate;  // [frames]
  int32_t frames;
};
static_assert(sizeof(Header) == 32);

int64_t FrameBytes(int num_points) { return int64_t{12} * num_points; }

Header ParseHeader(std::string_view bytes, int64_t file_size, const std::string& path) {
  Header header;
  if (bytes.size() < sizeof(header) ||
      std::memcmp(bytes.data(), kSignature, sizeof(kSignature)) != 0)
    throw InputError(path, "not a point cache: expected a file that begins with POINTCACHE2");
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.version != kVersion || header.points < 1 || header.frames < 0)
    throw InputError(path, Format("found version %d, %d points and %d frames, expected version 1 "
                                  "of a positive number of points",
                                  header.version, header.points, header.frames));
  if ((file_size - int64_t{sizeof(header)}) / FrameBytes(header.points) < header.frames)
    throw InputError(path, Format("found %lld bytes, expected %d frames of %d points",
                                  static_cast<long long>(file_size), header.frames, header.points));
  return header;
}

}  // namespace

GeometryCacheWriter::GeometryCacheWriter(std::string path, int num_points, int kept_frames)
    : path_(std::move(path)), num_points_(num_points), num_frames_(kept_frames), descriptor_(-1) {
  CHECK_GE(num_points, 1);
  CHECK_GE(kept_frames, 0);
  if (kept_frames == 0) {
    const Header header = {"POINTCACHE2", kVersion, num_points, 0, 1, 0};
    WriteFileAtomically(path_, {reinterpret_cast<const char*>(&header), sizeof(header)});
  }
  descriptor_ = open(path_.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor_ < 0) throw InputError(path_, std::strerror(errno));
  try {
    char bytes[sizeof(Header)];
    const ssize_t count = pread(descriptor_, bytes, sizeof(bytes), 0);
    const Header header = ParseHeader({bytes, size_t(std::max<ssize_t>(count, 0))},
                                      lseek(descriptor_, 0, SEEK_END), path_);
    if (header.points != num_points || header.frames < kept_frames)
      throw InputError(path_, Format("found %d frames of %d points, expected %d frames of %d",
                                     header.frames, header.points, kept_frames, num_points));
    WriteHeader();
    if (ftruncate(descriptor_, sizeof(Header) + kept_frames * FrameBytes(num_points)) != 0)
      throw InputError(path_, std::strerror(errno));
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

GeometryCacheWriter::~GeometryCacheWriter() { close(descriptor_); }

void GeometryCacheWriter::WriteAt(int64_t offset, const void* data, size_t size) {
  const char* next = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = pwrite(descriptor_, next, size, offset);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw InputError(path_, std::strerror(written < 0 ? errno : ENOSPC));
    next += written;
    offset += written;
    size -= written;
  }
}

void GeometryCacheWriter::WriteHeader() {
  const Header header = {"POINTCACHE2", kVersion, num_points_, 0, 1, num_frames_};
  WriteAt(0, &header, sizeof(header));
}

void GeometryCacheWriter::Append(const Eigen::VectorXd& x) {
  CHECK_EQ(x.size(), 3 * num_points_);
  const Eigen::VectorXf frame = x.cast<float>();
  WriteAt(sizeof(Header) + num_frames_ * FrameBytes(num_points_), frame.data(),
          FrameBytes(num_points_));
  fdatasync(descriptor_);
  ++num_frames_;
  WriteHeader();
}

}  // namespace drape
