// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "physics/util/atomic_file.h"

namespace drape::test {

// Reads the frames of a point cache PC2 as other programs do [m], shape [3V] each.
inline std::vector<Eigen::VectorXf> ReadCacheFrames(const std::string& path) {
  const std::string bytes = ReadOwnFile(path);
  int32_t points = 0, count = 0;
  if (bytes.size() < 32) {
    ADD_FAILURE() << path << " is shorter than its header";
    return {};
  }
  std::memcpy(&points, bytes.data() + 16, sizeof(points));
  std::memcpy(&count, bytes.data() + 28, sizeof(count));
  const std::size_t size = 12 * static_cast<std::size_t>(points);
  EXPECT_GE(bytes.size(), 32 + count * size) << path;
  std::vector<Eigen::VectorXf> frames;
  for (int frame = 0; frame < count && 32 + (frame + 1) * size <= bytes.size(); ++frame) {
    frames.emplace_back(3 * points);
    std::memcpy(frames.back().data(), bytes.data() + 32 + frame * size, size);
  }
  return frames;
}

}  // namespace drape::test
