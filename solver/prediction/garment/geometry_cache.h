// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace drape {

// Positions over time as a point cache PC2, which Blender and others read beside the OBJ of the
// first frame: a header of 32 bytes ("POINTCACHE2" and a NUL; int32 version 1 and number of points;
// float32 start and sample rate in frames, 0 and 1; int32 number of frames), then float32 x y z of
// each point of each frame, all little-endian [m].

// Writes such a file frame by frame. After each frame the file is complete: the frame is on the
// disk before the header counts it, so that an interrupted run leaves a readable file.
class GeometryCacheWriter {
 public:
  // Begins a new file in place of any other, or, with kept_frames > 0, keeps the first frames of
  // the file that an interrupted run has left and removes the others. Throws InputError when the
  // file cannot be written, is a link, or has not so many frames of so many points.
  GeometryCacheWriter(std::string path, int num_points, int kept_frames = 0);
  GeometryCacheWriter(const GeometryCacheWriter&) = delete;
  GeometryCacheWriter& operator=(const GeometryCacheWriter&) = delete;
  ~GeometryCacheWriter();

  // x: [m], shape [3V], CHECKed. Throws InputError when the disk is full.
  void Append(const Eigen::VectorXd& x);
  int num_frames() const { return num_frames_; }

 private:
  void WriteAt(int64_t offset, const void* data, size_t size);
  void WriteHeader();

  std::string path_;
  int num_points_;
  int num_frames_;
  int descriptor_;
};

}  // namespace drape
