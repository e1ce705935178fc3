// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "losses/camera/camera.h"
#include "losses/camera/photo/marker/camera_pose.h"
#include "losses/image/image.h"

// Internal to losses/camera/photo: pictures as a camera straight above would show them.
namespace drape {

struct Rectified {
  GrayImage silhouette;
  Camera camera;
};

// What a pinhole at the same place sees that looks straight down: the homography K R K⁻¹ of the
// coverage, cut to the cloth and a margin.
Rectified Rectify(const cv::Mat1f& coverage, const PhotoPose& pose);

// The image of a profile [m] that the published camera sees, black on white.
GrayImage RenderProfile(const Eigen::VectorXd& radius);

}  // namespace drape
