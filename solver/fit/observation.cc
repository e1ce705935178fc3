// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/observation.h"

#include "losses/outline/outline.h"

namespace drape {

Camera Observation::outline_camera() const {
  Camera scaled = camera;
  if (camera.kind == CameraKind::kOrthographic) scaled.scale = Camera().scale;
  return scaled;
}

std::optional<Eigen::VectorXd> Observation::MeasureRadius(int angles) const {
  Outline outline;
  if (!OutlineFromImage(image, camera, angles, &outline)) return std::nullopt;
  return outline.radius * (outline_camera().pixels_per_metre() / camera.pixels_per_metre());
}

}  // namespace drape
