// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/solid.h"

namespace drape {
namespace {

Vec3<double> Plain(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }

struct SolidMaker {
  std::optional<Solid> operator()(const PlaneObstacle& plane) const {
    return Solid{.kind = Solid::Kind::kPlane, .first = Plain(plane.normal), .size = plane.offset};
  }
  std::optional<Solid> operator()(const SphereObstacle& sphere) const {
    return Solid{
        .kind = Solid::Kind::kSphere, .first = Plain(sphere.centre), .size = sphere.radius};
  }
  std::optional<Solid> operator()(const CapsuleObstacle& capsule) const {
    return Solid{.kind = Solid::Kind::kCapsule,
                 .first = Plain(capsule.from),
                 .second = Plain(capsule.to),
                 .size = capsule.radius};
  }
  std::optional<Solid> operator()(const PlateObstacle& plate) const {
    return Solid{.kind = Solid::Kind::kPlate,
                 .first = Plain(plate.top),
                 .size = plate.radius,
                 .thickness = plate.thickness,
                 .rim_radius = plate.rim_radius};
  }
  std::optional<Solid> operator()(const std::shared_ptr<const SurfaceObstacle>&) const {
    return std::nullopt;
  }
};

}  // namespace

std::optional<Solid> MakeSolid(const Obstacle& obstacle) {
  return std::visit(SolidMaker(), obstacle);
}

}  // namespace drape
