// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "losses/camera/camera.h"

namespace drape {

// Where the depth that a camera sees is counted from: its eye, or, of an orthographic camera, the
// plane z = 0 [m]. A point at z has the depth DepthOrigin − z.
inline double DepthOrigin(const Camera& camera) {
  return camera.is_pinhole() ? camera.eye_height : 0.0;
}

// A camera that looks in any direction. The world is turned and moved, x ↦ turn·x + move, to where
// `camera` looks straight down on it.
struct View {
  Camera camera;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  // a rotation
  Eigen::Vector3d move = Eigen::Vector3d::Zero();      // [m]

  View() = default;
  // Looks straight down.
  View(const Camera& from_above) : camera(from_above) {}  // NOLINT(google-explicit-constructor)

  // Throws InputError (prefix `where`) as Camera::Check does, and for a `turn` that is no rotation
  // and a `move` that is not finite.
  void Check(const std::string& where) const;

  // Positions [m], shape [3V], in the frame of `camera`.
  Eigen::VectorXd FromWorld(const Eigen::VectorXd& x) const;
  // The derivative by a point of the world from that by the point in the frame of `camera`.
  Eigen::Vector3d AdjFromWorld(const Eigen::Vector3d& adj) const { return turn.transpose() * adj; }
  // The point of the world that is seen at an image point (column, row) [px] at a depth [m].
  Eigen::Vector3d WorldFromImage(const Eigen::Vector2d& image, double depth) const;
};

// The view from `position` to `target` [m], with `up` upwards in the image. The eye of a pinhole
// comes to `position` and its optical axis through `target`; an orthographic camera shows both at
// (cx, cy) and counts depth from `position`. Throws InputError (prefix `where`) where these do not
// define a view, and as Check does.
View LookAt(const Camera& camera, const Eigen::Vector3d& position, const Eigen::Vector3d& target,
            const Eigen::Vector3d& up, const std::string& where);

}  // namespace drape
