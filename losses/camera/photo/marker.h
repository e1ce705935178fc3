// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "losses/camera/photo/cloth_mask.h"

// Internal to losses/camera/photo: what says where the camera was.
namespace drape {

// The rim of the disc on the cloth.
struct DiscRim {
  cv::RotatedRect ellipse;              // [px of the working picture]
  std::vector<Eigen::Vector2d> points;  // on it [px]
  double share = 0.0;                   // of the rays on which it is seen
};

// The rim of a disc inside a cloth: on each ray from the cloth's middle the places where the colour
// changes most, through which a circle is drawn by RANSAC and then an ellipse by least squares,
// with a tolerance that shrinks. None where less than half of the rays agree.
std::optional<DiscRim> FindDisc(const PhotoPlanes& planes, const cv::Mat1b& cloth);

// The corners of the largest AprilTag of family 36h11 [px of the working picture], as in PoseInput.
std::optional<std::array<Eigen::Vector2d, 4>> FindTag(const PhotoPlanes& planes);

}  // namespace drape
