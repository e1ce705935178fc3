// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "losses/camera/photo/picture/photo_planes.h"

// Internal to losses/camera/photo: what tells cloth from ground.
namespace drape {

// A measure of being cloth, and where it separates.
struct Feature {
  cv::Mat1f value;
  double threshold = 0.0, separation = 0.0;  // of the variance, between the two classes

  cv::Mat1b Mask() const { return (value > threshold) / 255; }
};

// The distance from the ground's colour, `rest` being the colours less it.
Feature DistanceFeature(const cv::Mat3f& rest);

// The distance from what the ground can be, in light and in shadow: a shadow multiplies the stored
// red, green and blue by one number, which moves the colour along a curve.
Feature ShadowedFeature(const PhotoPlanes& planes, const cv::Mat3f& rest, const cv::Mat1b& border);

// Fisher's linear discriminant of the two sides of a mask, and of the sides that it makes, …
Feature DiscriminantFeature(const cv::Mat3f& rest, cv::Mat1b mask);

}  // namespace drape
