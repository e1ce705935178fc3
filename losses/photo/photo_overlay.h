// SPDX-License-Identifier: Apache-2.0
// Internal to losses/photo: pictures as a camera straight above shows them, with what was found.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/photo/marker/camera_pose.h"
#include "losses/photo/marker/disc.h"

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

struct Rectified {
  GrayImage silhouette;
  Camera camera;
};

// What a pinhole at the same place sees that looks straight down: the homography K R K⁻¹ of the
// coverage, cut to the cloth and a margin.
Rectified Rectify(const cv::Mat1f& coverage, const PhotoPose& pose);

// The image of a profile [m] that the published camera sees, black on white.
GrayImage RenderProfile(const Eigen::VectorXd& radius);

}  // namespace drape
