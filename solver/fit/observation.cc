// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observation.h"

#include <cmath>

#include "losses/outline/outline.h"

namespace drape {

Camera Observation::outline_camera() const {
  Camera scaled = camera;
  const Camera published;
  if (camera.kind == CameraKind::kOrthographic) {
    scaled.scale = published.scale;
  } else if (camera.width != published.width || camera.height != published.height) {
    const double longer = published.scale / camera.pixels_per_metre();  // the published pinhole
    scaled.field_of_view = 2 * std::atan(std::tan(0.5 * camera.field_of_view) / longer);
  }
  return scaled;
}

std::optional<Eigen::VectorXd> Observation::MeasureRadius(int angles) const {
  Outline outline;
  if (!OutlineFromImage(image, camera, angles, &outline)) return std::nullopt;
  return outline.radius * (outline_camera().pixels_per_metre() / camera.pixels_per_metre());
}

}  // namespace drape
