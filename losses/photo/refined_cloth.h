// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "losses/photo/cloth_mask.h"

// Internal to losses/photo: where the cloth ends, to a part of a pixel.
namespace drape {

// The cloth with its outline between the colours on either side of it: each pixel near the outline
// is compared with the mean colours of cloth and ground in its neighbourhood, and the outline
// moves until that changes nothing. `disc_coverage`: that by the disc, which is not cloth, though
// inside it. Throws PhotoFailure where cloth and ground are too alike.
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
