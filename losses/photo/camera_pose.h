// SPDX-License-Identifier: Apache-2.0
// Internal to losses/photo: the printed marker, and the camera that follows from it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "losses/outline/outline.h"

namespace drape {

struct PhotoPlanes;

// The corners of the largest AprilTag of family 36h11 [px of the working picture], as in PoseInput.
std::optional<std::array<Eigen::Vector2d, 4>> FindTag(const PhotoPlanes& planes);

// A pinhole above the support [m, px]. Its own frame is x right, y up and z away from the scene; a
// rotation about the axis (tilt.x, tilt.y, 0) takes it to that of the world.
struct PhotoPose {
  double focal = 0.0;                              // [px]
  Eigen::Vector2d principal;                       // column and row of the optical axis
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();  // [rad]
  Eigen::Vector3d eye = Eigen::Vector3d::Zero();   // [m]

  Eigen::Matrix3d WorldFromCamera() const;
  // The point of the plane at height z [m] that is seen at a point of the picture [px].
  Eigen::Vector2d WorldFromImage(const Eigen::Vector2d& image, double z) const;
  Eigen::Vector2d ImageFromWorld(const Eigen::Vector3d& x) const;
};

// What is known of it. The rim is a horizontal circle about the world's z axis. The tag lies
// horizontally anywhere; its corners are counter-clockwise in the world, from that of least x and y
// of the unturned tag.
struct PoseInput {
  double focal = 0.0;
  Eigen::Vector2d principal;
  std::vector<Eigen::Vector2d> rim;  // points seen on it [px]; empty: no disc
  double rim_radius = 0.0, rim_height = 0.0;
  std::optional<std::array<Eigen::Vector2d, 4>> tag;
  double tag_side = 0.0, tag_height = 0.0;
  std::vector<Eigen::Vector2d> outline;  // of the cloth, in order [px]
  DrapeDiscs discs;
};

struct FoundPose {
  PhotoPose pose;
  double rms = 0.0;        // of the rim or the tag's corners [px]
  double tilt_sd = 0.0;    // standard deviation of the tilt, of its less certain component [rad]
  double height_sd = 0.0;  // of the eye's height and so of the scale, relative
  double first_harmonic = 0.0;  // of the hem about the axis, which the pose leaves over [m]
};

// Least squares over rim and tag. Near the vertical a circle says little of the tilt, and it cannot
// tell a tilt from its reflection in the line of sight; a tag does not say where the support is. So
// the hem, at its estimated heights, is required to have no first harmonic, to 1 mm, as a drape
// whose folds favour no side (CentreOnOutline): 0.1 to 1.3 mm in 18 simulated drapes. None where
// nothing fits.
std::optional<FoundPose> FindPose(const PoseInput& input);

}  // namespace drape
