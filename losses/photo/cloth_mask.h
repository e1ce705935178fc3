// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "losses/photo/photo.h"
#include "losses/photo/photo_planes.h"

// Internal to losses/photo: which pixels show the cloth (cloth_mask.cc), and where it ends, to a
// part of a pixel (refined_cloth.cc).

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

// The cloth with its outline between the colours on either side of it: each pixel near the outline
// is compared with the mean colours of cloth and ground in its neighbourhood, and the outline
// moves until that changes nothing. `disc_coverage`: the coverage by the disc, which lies inside
// the outline and is no cloth. Throws PhotoFailure where cloth and ground are too alike.
struct RefinedCloth {
  cv::Mat1b mask;
  cv::Mat1f coverage;     // 0 … 1
  double contrast = 0.0;  // median along the outline [Lab units]
  double weak = 0.0;      // share of the outline with little contrast
  double at_disc = 0.0;   // share of the outline so near to the rim of the disc that both are mixed
  double blur = 0.0;      // standard deviation of the edge [px]
};
RefinedCloth RefineCloth(const PhotoPlanes& planes, const RoughCloth& rough,
                         const cv::Mat1f& disc_coverage);

}  // namespace drape
