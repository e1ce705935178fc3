// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/cloth_model.h"

namespace drape {

// A drape as the camera sees it.
struct DrapeView {
  GrayImage silhouette;                      // coverage by 4×4 samples a pixel
  std::optional<double> drape_coefficient;   // by the area of the coverage; none for a cloth or a
                                             // support of other radii than the standard's
  std::optional<int> folds;                  // none where the outline has gaps
  std::optional<SilhouetteMetrics> metrics;  // against an image, where one is given
};

// x: positions [m], shape [3V]; image: of the camera's size, or nullptr. None when the cloth is not
// in front of the camera or a million pixels away.
std::optional<DrapeView> ViewDrape(const ClothModel& model, const Eigen::VectorXd& x,
                                   const Camera& camera, const GrayImage* image);

}  // namespace drape
