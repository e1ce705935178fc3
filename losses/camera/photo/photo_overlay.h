// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/photo/marker/disc.h"
#include "losses/image/image.h"

// Internal to losses/camera/photo: the picture that shows what was found.
namespace drape {

struct PhotoMarks {
  std::vector<cv::Point> outline;
  std::optional<cv::RotatedRect> disc;
  std::optional<std::array<Eigen::Vector2d, 4>> tag;
  std::vector<cv::Point> flat;                 // outline of the flat specimen
  std::vector<std::vector<cv::Point>> faults;  // where something is wrong
  std::string text;                            // below the picture, wrapped
  bool refused = false;
};

RgbImage RenderMarks(const PhotoPlanes& planes, const PhotoMarks& marks);

}  // namespace drape
