// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/view.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {

void View::Check(const std::string& where) const {
  constexpr double kRounding = 1e-6;
  camera.Check(where);
  const double off = (turn * turn.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(off <= kRounding && turn.determinant() > 0))
    throw InputError(where, Format("turn is %g off a rotation (determinant %g), expected a matrix "
                                   "of orthonormal rows, determinant 1",
                                   off, turn.determinant()));
  if (!move.allFinite()) throw InputError(where, "move is not finite, expected metres");
}

Eigen::VectorXd View::FromWorld(const Eigen::VectorXd& x) const {
  Eigen::VectorXd seen(x.size());
  for (Eigen::Index i = 0; i < x.size(); i += 3) seen.segment<3>(i) = turn * x.segment<3>(i) + move;
  return seen;
}

Eigen::Vector3d View::WorldFromImage(const Eigen::Vector2d& image, double depth) const {
  const double z = DepthOrigin(camera) - depth;
  const Eigen::Vector2d place = camera.WorldFromImage(image, z);
  return turn.transpose() * (Eigen::Vector3d(place.x(), place.y(), z) - move);
}

View LookAt(const Camera& camera, const Eigen::Vector3d& position, const Eigen::Vector3d& target,
            const Eigen::Vector3d& up, const std::string& where) {
  constexpr double kLeastSine = 1e-6;
  const Eigen::Vector3d back = (position - target).normalized();
  const Eigen::Vector3d right = up.normalized().cross(back);
  if (!(right.norm() > kLeastSine && right.allFinite()))
    throw InputError(where, Format("found a view from (%g, %g, %g) to (%g, %g, %g) with (%g, %g, "
                                   "%g) upwards, expected two places and another direction",
                                   position.x(), position.y(), position.z(), target.x(), target.y(),
                                   target.z(), up.x(), up.y(), up.z()));
  View view(camera);
  view.turn.row(0) = right.normalized();
  view.turn.row(1) = back.cross(right).normalized();
  view.turn.row(2) = back;
  if (camera.is_pinhole()) view.move << camera.eye_x, camera.eye_y, camera.eye_height;
  view.move -= view.turn * position;
  view.Check(where);
  return view;
}

}  // namespace drape
