// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/obstacles/obstacle.h"

#include "physics/cloth/contact/obstacles/solid.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"

namespace drape {

Eigen::Vector3d SurfaceMove(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  const auto* surface = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle);
  return surface == nullptr ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : (*surface)->Move(x);
}

ObstacleDistance DistanceTo(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  return InEigen(DistanceTo(MakeSolid(obstacle), Plain(x)));
}

}  // namespace drape
