// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

#include "losses/camera/photo/picture/photo_options.h"
#include "losses/camera/photo/picture/photo_planes.h"
#include "losses/image/image.h"

// Internal to losses/camera/photo: what a photograph and its options have to be.
namespace drape {

// Throws InputError for options that contradict one another.
void CheckOptions(const PhotoOptions& options);

// The focal length [px of the photograph], which is by the diagonal: that of the options, or that
// of the file. Throws PhotoFailure where there is none, and for a file that was cropped.
double FocalLength(const Photograph& photo, const PhotoOptions& options);

// Throws PhotoFailure for a highlight on the cloth without detail.
void CheckGlare(const PhotoPlanes& planes, const cv::Mat1b& cloth);

// Throws PhotoFailure for an outline whose blur is a standard deviation [m] of too much.
void CheckBlur(double blur);

}  // namespace drape
