// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "losses/photo/photo_options.h"
#include "losses/photo/photo_planes.h"

// Internal to losses/photo: which pixels show the cloth.
namespace drape {

// The cloth without holes, 1 = cloth. The ground's colour is a quadratic function of the place,
// fitted to the border of the picture, so that a shadow or an uneven light at its edges does not
// count; the cloth is what differs from it, by Otsu's threshold of the distance in CIE Lab or of
// Fisher's linear discriminant, whichever separates better; with points of the user, or where both
// separate badly, OpenCV's GrabCut continues from there. Of several parts, the one nearest to
// the picture's centre counts among those that are not small beside the largest. Throws
// PhotoFailure.
struct RoughCloth {
  cv::Mat1b mask;
  cv::Mat1b pieces;           // all that may be cloth; a disc that hides the rest lies between them
  double ground_noise = 0.0;  // robust standard deviation of the border [Lab units]
  std::vector<std::string> warnings;  // on what was cut
};
RoughCloth FindCloth(const PhotoPlanes& planes, const PhotoOptions& options);

}  // namespace drape
