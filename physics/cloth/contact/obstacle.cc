// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/obstacle.h"

#include "physics/cloth/contact/solid.h"
#include "physics/cloth/contact/surface_obstacle.h"

namespace drape {
namespace {

ObstacleDistance InEigen(const SolidDistance& distance) {
  const SymmetricMatrix& c = distance.curvature;
  ObstacleDistance result{.value = distance.value,
                          .normal = {distance.normal.x, distance.normal.y, distance.normal.z}};
  result.curvature << c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, c.xz, c.yz, c.zz;
  return result;
}

}  // namespace

bool IsConvex(const Obstacle& obstacle) {
  return !std::holds_alternative<std::shared_ptr<const SurfaceObstacle>>(obstacle);
}

Eigen::Vector3d SurfaceMove(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  const auto* surface = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle);
  return surface == nullptr ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : (*surface)->Move(x);
}

ObstacleDistance DistanceTo(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  if (const auto* surface = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle))
    return (*surface)->DistanceTo(x);
  return InEigen(DistanceTo(*MakeSolid(obstacle), {x.x(), x.y(), x.z()}));
}

}  // namespace drape
