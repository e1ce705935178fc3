// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "losses/metrics/metrics.h"
#include "physics/cloth/cloth_model.h"

namespace drape {

// The camera as a user sets it.
struct CameraInput {
  static constexpr double kImageCentre = std::numeric_limits<double>::quiet_NaN();

  std::string kind = "orthographic";
  int width = 256, height = 256;  // [px]
  double cx = kImageCentre;       // column and row of the support's centre [px]
  double cy = kImageCentre;
  double scale = Camera().scale;  // orthographic only [px/m]
};
// Throws InputError.
Camera MakeCamera(const CameraInput& input);

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
