// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "losses/camera/photo/cloth/cloth_mask.h"

// Internal to losses/camera/photo.
namespace drape {

// The one piece of cloth, without holes, among the parts of a mask: the part nearest to the
// picture's centre among those that are not small beside the largest, or the pieces around a disc
// that hides the rest. Throws PhotoFailure where there is none, two, or one that is cut off.
cv::Mat1b PickCloth(const PhotoPlanes& planes, const PhotoOptions& options, const cv::Mat1b& mask,
                    std::vector<std::string>* warnings);

}  // namespace drape
