// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "losses/camera/camera.h"
#include "losses/image/image.h"

namespace drape {

using Color = std::array<uint8_t, 3>;

struct OverlayOptions {
  int upscale = 3;
  double line_width = 2.0;  // of the outlines [upscaled px]; the support circle is half as wide
  Color fitted = {220, 40, 30};
  Color measured = {20, 110, 230};
  Color support = {90, 150, 90};
};

// Renders a fit: the image in pale grey, enlarged, and on it the measured and the fitted outline
// (profiles [px], any number of angles ≥ 3), the support circle of radius 9 cm in the support
// plane, and a legend.
RgbImage RenderOverlay(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                       const Eigen::VectorXd& fitted_radius, const Camera& camera,
                       const OverlayOptions& options = {});

}  // namespace drape
