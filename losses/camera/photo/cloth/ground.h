// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

// Internal to losses/camera/photo: what lies around the cloth.
namespace drape {

// 1, x, y, x², xy, y² of a place, with x and y from −1 to 1.
using Monomials = cv::Vec<double, 6>;
Monomials MonomialsAt(int column, int row, cv::Size size);

// The ground's colour as a quadratic function of the place.
struct Ground {
  cv::Matx<double, 6, 3> coefficients;
  double noise = 0.0;  // robust standard deviation [Lab units]

  cv::Vec3d At(const Monomials& m) const {
    const cv::Matx<double, 1, 3> color = m.t() * coefficients;
    return {color(0), color(1), color(2)};
  }
};

// Least squares with Tukey's weights over the border's pixels.
Ground FitGround(const cv::Mat3f& lab, const cv::Mat1b& border);

// The colours less those of the ground.
cv::Mat3f WithoutGround(const cv::Mat3f& lab, const Ground& ground);

}  // namespace drape
