// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "losses/camera/camera.h"
#include "losses/image/image.h"

namespace drape {

using Color = std::array<uint8_t, 3>;

struct OverlayOptions {
  int upscale = 0;          // 0: 3 for a published image, 1 for a large one (about 1000 px)
  double line_width = 0.0;  // of the outlines [upscaled px]; the circles are half as wide; 0: 2,
                            // and more in large pictures
  Color fitted = {220, 40, 30};
  Color measured = {20, 110, 230};
  Color support = {90, 150, 90};
  Color flat = {150, 120, 60};
};

// Renders a fit: the image in pale grey, enlarged, and on it the measured and the fitted outline
// (profiles [px], any number of angles ≥ 3) and the circle of the support in its plane. The page of
// drape_report shows the same as layers, with a key.
RgbImage RenderOverlay(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                       const Eigen::VectorXd& fitted_radius, const Camera& camera,
                       const DrapeDiscs& discs, const OverlayOptions& options = {});

// Renders how an image was measured, over the silhouette or over the picture that it was made from:
// as above, with the measured outline [px], and the circles of the flat cloth and the support.
RgbImage RenderMeasurement(const GrayImage& image, const Eigen::VectorXd& measured_radius,
                           const Camera& camera, const DrapeDiscs& discs,
                           const OverlayOptions& options = {});

}  // namespace drape
