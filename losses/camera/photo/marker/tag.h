// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "losses/camera/photo/picture/photo_planes.h"

// Internal to losses/camera/photo: the printed marker.
namespace drape {

// The corners of the largest AprilTag of family 36h11 [px of the working picture], as in PoseInput.
std::optional<std::array<Eigen::Vector2d, 4>> FindTag(const PhotoPlanes& planes);

}  // namespace drape
