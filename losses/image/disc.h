// SPDX-License-Identifier: Apache-2.0
// Internal to losses: the disc on the cloth, and its rim to a part of a pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "losses/image/image.h"
#include "losses/image/photo_planes.h"

namespace drape {

// The rim of the disc on the cloth.
struct DiscRim {
  cv::RotatedRect ellipse;              // [px of the working picture]
  std::vector<Eigen::Vector2d> points;  // on it [px]
  double share = 0.0;                   // of the rays on which it is seen
  double blur = 1.0;                    // standard deviation [px]
  bool is_line = false;                 // as of a clear disc: little changes across it, much on it
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

// Points of the rim [px of the photograph] near an ellipse: on rays across it, the place of a step
// of the light between two linear functions (StepFinder), blurred alike on all rays. Rays without a
// clear step are left out.
struct RimPoints {
  std::vector<Eigen::Vector2d> points;
  double share = 0.0;    // of the rays
  double blur = 0.0;     // standard deviation [px]
  bool is_line = false;  // DiscRim
};
RimPoints LocateRim(const RgbImage& photo, const cv::RotatedRect& ellipse, bool is_on_line = false);

// Finds the rim again, in the photograph at its full size, where the cloth beside it is wide enough
// not to mix its colour with the ground's. `mask`: the cloth in the working picture.
void LocateFinely(const RgbImage& photo, const PhotoPlanes& planes, const cv::Mat1b& mask,
                  DiscRim* rim);

}  // namespace drape
