// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "losses/camera/photo/photo.h"

// Internal to losses/camera/photo: which pixels show the cloth.
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
  cv::Mat3f lab;         // CIE Lab, slightly smoothed
  double scale = 1.0;    // working pixels to one of the photograph
  double saturated = 0;  // share of the border's pixels that are white without detail
};
PhotoPlanes MakePlanes(const RgbImage& image);

// Throws PhotoFailure where nothing can be seen.
void CheckExposure(const PhotoPlanes& planes);

// The cloth without holes, 1 = cloth. The ground's colour is a quadratic function of the place,
// fitted to the border of the picture, so that a shadow or an uneven light at its edges does not
// count; the cloth is what differs from it, by Otsu's threshold of the distance in CIE Lab or of
// Fisher's linear discriminant, whichever separates better; with points of the user, or where both
// separate badly, OpenCV's GrabCut continues from there. Of several parts, the one nearest to
// the picture's centre counts among those that are not small beside the largest. Throws
// PhotoFailure.
struct RoughCloth {
  cv::Mat1b mask;
  double ground_noise = 0.0;          // robust standard deviation of the border [Lab units]
  std::vector<std::string> warnings;  // on what was cut
};
RoughCloth FindCloth(const PhotoPlanes& planes, const PhotoOptions& options);

// The cloth with its outline between the colours on either side of it: each pixel near the outline
// is compared with the mean colours of cloth and ground in its neighbourhood, and the outline
// moves until that changes nothing. `disc`: pixels that are not cloth, though inside it. Throws
// PhotoFailure where cloth and ground are too alike.
struct RefinedCloth {
  cv::Mat1b mask;
  cv::Mat1f coverage;     // 0 … 1
  double contrast = 0.0;  // median along the outline [Lab units]
  double weak = 0.0;      // share of the outline with little contrast
  double blur = 0.0;      // standard deviation of the edge [px]
};
RefinedCloth RefineCloth(const PhotoPlanes& planes, const RoughCloth& rough, const cv::Mat1b& disc);

// The convex hull of a mask.
cv::Mat1b FilledHull(const cv::Mat1b& mask);

// The longest closed outline of a mask.
std::vector<cv::Point> LongestOutline(const cv::Mat1b& mask);

}  // namespace drape
