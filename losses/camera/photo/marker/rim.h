// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "losses/image/image.h"

// Internal to losses/camera/photo: the disc's rim to a part of a pixel.
namespace drape {

// Points of the rim [px of the photograph] near an ellipse: on rays across it, the place of a step
// of the light between two linear functions (StepFinder), blurred alike on all rays. Rays without a
// clear step are left out.
struct RimPoints {
  std::vector<Eigen::Vector2d> points;
  double share = 0.0;  // of the rays
  double blur = 0.0;   // standard deviation [px]
};
RimPoints LocateRim(const RgbImage& photo, const cv::RotatedRect& ellipse);

}  // namespace drape
