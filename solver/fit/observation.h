// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "physics/cloth/state.h"

namespace drape {

// One silhouette to be fitted, and the shape from which its drape starts: many drapes are stable,
// so the start says which of them is meant [METHODS, P13].
struct Observation {
  std::string name;  // file name without folder and extension
  std::string file;
  GrayImage image;
  Camera camera;           // its centre is the support's centre in this image
  Eigen::VectorXd radius;  // r(θ) of the image [px], shape [K]
  State start;
};

}  // namespace drape
