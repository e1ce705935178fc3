// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/obstacles/obstacle.h"

#include "physics/cloth/contact/obstacles/surface_obstacle.h"

namespace drape {
namespace {

struct SolidMaker {
  Solid operator()(const PlaneObstacle& plane) const {
    return Solid{.kind = Solid::Kind::kPlane, .first = Plain(plane.normal), .size = plane.offset};
  }
  Solid operator()(const SphereObstacle& sphere) const {
    return Solid{
        .kind = Solid::Kind::kSphere, .first = Plain(sphere.centre), .size = sphere.radius};
  }
  Solid operator()(const CapsuleObstacle& capsule) const {
    return Solid{.kind = Solid::Kind::kCapsule,
                 .first = Plain(capsule.from),
                 .second = Plain(capsule.to),
                 .size = capsule.radius};
  }
  Solid operator()(const PlateObstacle& plate) const {
    return Solid{.kind = Solid::Kind::kPlate,
                 .first = Plain(plate.top),
                 .size = plate.radius,
                 .thickness = plate.thickness,
                 .rim_radius = plate.rim_radius};
  }
  Solid operator()(const std::shared_ptr<const SurfaceObstacle>& surface) const {
    return Solid{.kind = Solid::Kind::kMesh, .surface = surface->view()};
  }
};

}  // namespace

Eigen::Vector3d SurfaceMove(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  const auto* surface = std::get_if<std::shared_ptr<const SurfaceObstacle>>(&obstacle);
  return surface == nullptr ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : (*surface)->Move(x);
}

ObstacleDistance DistanceTo(const Obstacle& obstacle, const Eigen::Vector3d& x) {
  return InEigen(DistanceTo(MakeSolid(obstacle), Plain(x)));
}

Solid MakeSolid(const Obstacle& obstacle) { return std::visit(SolidMaker(), obstacle); }

ObstacleDistance InEigen(const SolidDistance& distance) {
  const SymmetricMatrix& c = distance.curvature;
  ObstacleDistance result{.value = distance.value,
                          .normal = {distance.normal.x, distance.normal.y, distance.normal.z}};
  result.curvature << c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, c.xz, c.yz, c.zz;
  return result;
}

}  // namespace drape
