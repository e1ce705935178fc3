// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/cloth_model.h"

namespace drape {

// A drape as the camera sees it.
struct DrapeView {
  GrayImage silhouette;                     // coverage by 4×4 samples a pixel
  std::optional<double> drape_coefficient;  // by the area of the coverage; none for a cloth or a
                                            // support of other radii than the discs', and with a
                                            // fault
  std::string fault;                        // why this is no picture of a drape: "tangled" (its
                                            // area is less than the support's or more than the
                                            // cloth's), "not all in the picture", "too small in the
                                            // picture"; or empty
  std::optional<int> folds;                 // none where the outline has gaps
  std::optional<SilhouetteMetrics> metrics;  // against an image, where one is given
};

// x: positions [m], shape [3V]; image: of the camera's size, or nullptr. None when the cloth is not
// in front of the camera or a million pixels away.
std::optional<DrapeView> ViewDrape(const ClothModel& model, const Eigen::VectorXd& x,
                                   const Camera& camera, const DrapeDiscs& discs,
                                   const GrayImage* image);

}  // namespace drape
