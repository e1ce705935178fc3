// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "losses/image/image.h"
#include "losses/photo/picture/photo_options.h"

// Internal to losses/photo: the picture that is worked on.
namespace drape {

// Ends the work on a photograph; MeasurePhoto makes a result with this fault of it.
struct PhotoFailure {
  PhotoFault fault;
  std::string reason;
  std::vector<std::vector<cv::Point>> marks = {};  // curves that show where, in the working picture
};

// A photograph at its working size.
struct PhotoPlanes {
  cv::Mat3b rgb;
  cv::Mat3f light;       // red, green and blue in linear light, slightly smoothed
  cv::Mat1f luma;        // the light of the luma, in the same way
  cv::Mat3f lab;         // the same in CIE Lab
  double scale = 1.0;    // working pixels to one of the photograph
  double saturated = 0;  // share of the border's pixels that are white without detail

  // The blur in the working picture for a blur in the photograph: standard deviations [px].
  double WorkingBlur(double blur_of_photo) const;
};
PhotoPlanes MakePlanes(const RgbImage& image);

// Throws PhotoFailure where nothing can be seen.
void CheckExposure(const PhotoPlanes& planes);

// The pixels along the border of a picture.
cv::Mat1b BorderMask(cv::Size size);

// A round structuring element.
cv::Mat1b RoundElement(int radius);

// The convex hull of a mask.
cv::Mat1b FilledHull(const cv::Mat1b& mask);

// The longest closed outline of a mask.
std::vector<cv::Point> LongestOutline(const cv::Mat1b& mask);

}  // namespace drape
