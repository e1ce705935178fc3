// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "losses/camera/photo/picture/photo_planes.h"

// Internal to losses/camera/photo: the disc on the cloth.
namespace drape {

// The rim of the disc on the cloth.
struct DiscRim {
  cv::RotatedRect ellipse;              // [px of the working picture]
  std::vector<Eigen::Vector2d> points;  // on it [px]
  double share = 0.0;                   // of the rays on which it is seen
  double blur = 1.0;                    // standard deviation [px]
};

// The ellipse through points, least squares.
cv::RotatedRect FitEllipse(const std::vector<Eigen::Vector2d>& points);

// The rim of a disc inside a cloth: on each ray from the cloth's middle the places where the colour
// changes most, through which a circle is drawn by RANSAC and then an ellipse by least squares,
// with a tolerance that shrinks. None where less than half of the rays agree.
std::optional<DiscRim> FindDisc(const PhotoPlanes& planes, const cv::Mat1b& cloth);

// The coverage by an ellipse, 0 … 1, of pixels of a picture of that size, blurred by a Gaussian of
// that standard deviation [px].
cv::Mat1f RenderEllipse(cv::Size size, const cv::RotatedRect& ellipse, double blur);

}  // namespace drape
