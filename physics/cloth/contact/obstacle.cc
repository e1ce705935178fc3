// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/obstacle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "physics/cloth/contact/surface_obstacle.h"

namespace drape {
namespace {

// From a point, less a radius. `free`: the projection onto the directions in which that point does
// not follow x.
ObstacleDistance AwayFrom(const Eigen::Vector3d& offset, double radius,
                          const Eigen::Matrix3d& free) {
  const double length = offset.norm();
  if (!(length > 0.0)) return {.value = -radius, .normal = Eigen::Vector3d::UnitZ()};
  const Eigen::Vector3d n = offset / length;
  return {.value = length - radius, .normal = n, .curvature = (free - n * n.transpose()) / length};
}

ObstacleDistance Distance(const PlaneObstacle& plane, const Eigen::Vector3d& x) {
  return {.value = plane.normal.dot(x) - plane.offset, .normal = plane.normal};
}

ObstacleDistance Distance(const SphereObstacle& sphere, const Eigen::Vector3d& x) {
  return AwayFrom(x - sphere.centre, sphere.radius, Eigen::Matrix3d::Identity());
}

ObstacleDistance Distance(const CapsuleObstacle& capsule, const Eigen::Vector3d& x) {
  const Eigen::Vector3d axis = capsule.to - capsule.from, offset = x - capsule.from;
  const double square = axis.squaredNorm();
  const double along = square > 0.0 ? axis.dot(offset) / square : 0.0;
  if (along <= 0.0) return AwayFrom(offset, capsule.radius, Eigen::Matrix3d::Identity());
  if (along >= 1.0) return AwayFrom(x - capsule.to, capsule.radius, Eigen::Matrix3d::Identity());
  return AwayFrom(offset - along * axis, capsule.radius,
                  Eigen::Matrix3d::Identity() - axis * axis.transpose() / square);
}

// In the half-plane of the axis: the distance from a rectangle with rounded corners.
ObstacleDistance Distance(const PlateObstacle& plate, const Eigen::Vector3d& x) {
  const Eigen::Vector3d offset = x - plate.top;
  const double r = offset.head<2>().norm(), half = 0.5 * plate.thickness;
  const double z = offset.z() + half, side = z < 0.0 ? -1.0 : 1.0;
  Eigen::Vector3d out = Eigen::Vector3d::UnitX();
  if (r > 0.0) out << offset.x() / r, offset.y() / r, 0.0;
  const Eigen::Vector3d up(0.0, 0.0, side), around = up.cross(out);
  // From the rectangle that the rim is around.
  const double over_r = r - (plate.radius - plate.rim_radius);
  const double over_z = side * z - (half - plate.rim_radius);
  ObstacleDistance distance;
  double slope_r = 0.0;  // ∂distance/∂r
  if (over_r > 0.0 && over_z > 0.0) {
    const double length = std::hypot(over_r, over_z);
    slope_r = over_r / length;
    const double slope_z = over_z / length;
    const Eigen::Vector3d along_rim = slope_z * out - slope_r * up;
    distance.value = length - plate.rim_radius;
    distance.normal = slope_r * out + slope_z * up;
    distance.curvature = along_rim * along_rim.transpose() / length;
  } else if (over_r > over_z) {
    slope_r = 1.0;
    distance.value = over_r - plate.rim_radius;
    distance.normal = out;
  } else {
    distance.value = over_z - plate.rim_radius;
    distance.normal = up;
  }
  if (slope_r > 0.0) distance.curvature += slope_r / r * around * around.transpose();
  return distance;
}

ObstacleDistance Distance(const std::shared_ptr<const SurfaceObstacle>& surface,
                          const Eigen::Vector3d& x) {
  return surface->DistanceTo(x);
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
  return std::visit([&](const auto& solid) { return Distance(solid, x); }, obstacle);
}

}  // namespace drape
