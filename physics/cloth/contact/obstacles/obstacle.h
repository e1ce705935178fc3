// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <variant>

#include "physics/cloth/contact/obstacles/surface_view.h"

namespace drape {

class SurfaceObstacle;

// Solids that a cloth cannot enter, by the signed distance from their surface [m], positive
// outside.

// The half-space below a plane.
struct PlaneObstacle {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit length, towards the cloth
  double offset = 0.0;                                // the surface: normal·x = offset [m]
};
struct SphereObstacle {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.1;  // [m]
};
// All points within a radius of a segment.
struct CapsuleObstacle {
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::UnitX();
  double radius = 0.1;  // [m]
};
// A horizontal disc with a rounded rim, such as the support of the drape test.
struct PlateObstacle {
  Eigen::Vector3d top = Eigen::Vector3d::Zero();  // the centre of its upper face
  double radius = 0.09;                           // [m]
  double thickness = 0.05;                        // [m]
  double rim_radius = 0.001;                      // [m], 0 < rim_radius ≤ thickness/2, radius
};
using Obstacle = std::variant<PlaneObstacle, SphereObstacle, CapsuleObstacle, PlateObstacle,
                              std::shared_ptr<const SurfaceObstacle>>;

// The distance from a surface to second order. Where several points of the surface are the nearest,
// the derivatives are those by one of them; a mesh of triangles has a smooth minimum there
// (SurfaceObstacle), whose gradient can be shorter than 1.
struct ObstacleDistance {
  double value = 0.0;                                   // [m]
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();     // its gradient, of unit length
  Eigen::Matrix3d curvature = Eigen::Matrix3d::Zero();  // its second derivatives [1/m]
};
ObstacleDistance DistanceTo(const Obstacle& obstacle, const Eigen::Vector3d& x);

// How far the surface near x has moved in the present step (SurfaceObstacle::Move) [m].
Eigen::Vector3d SurfaceMove(const Obstacle& obstacle, const Eigen::Vector3d& x);

// Distances from obstacles, for host and device [MODEL, M60].

// An obstacle as plain data.
struct Solid {
  enum class Kind : int { kPlane, kSphere, kCapsule, kPlate, kMesh };
  Kind kind = Kind::kPlane;
  // Plane: its normal. Sphere: its centre. Capsule: one end. Plate: the centre of its upper face.
  Vec3<double> first{0.0, 0.0, 0.0};
  Vec3<double> second{0.0, 0.0, 0.0};  // of a capsule: the other end
  double size = 0.0;                   // of a plane: its offset; of the others: the radius [m]
  double thickness = 0.0, rim_radius = 0.0;  // of a plate [m]
  SurfaceView surface = {};                  // of a mesh
};
inline Vec3<double> Plain(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
ObstacleDistance InEigen(const SolidDistance& distance);
// A view of the obstacle where that is a mesh.
Solid MakeSolid(const Obstacle& obstacle);

DRAPE_HD inline SolidDistance DistanceToPlate(const Solid& plate, const Vec3<double>& x) {
  const Vec3<double> offset = x - plate.first;
  const double r = std::hypot(offset.x, offset.y), half = 0.5 * plate.thickness;
  const double z = offset.z + half, side = z < 0.0 ? -1.0 : 1.0;
  Vec3<double> out{1.0, 0.0, 0.0};
  if (r > 0.0) out = {offset.x / r, offset.y / r, 0.0};
  const Vec3<double> up{0.0, 0.0, side}, around = Cross(up, out);
  // From the rectangle that the rim is around.
  const double over_r = r - (plate.size - plate.rim_radius);
  const double over_z = side * z - (half - plate.rim_radius);
  SolidDistance distance;
  double slope_r = 0.0;  // ∂distance/∂r
  if (over_r > 0.0 && over_z > 0.0) {
    const double length = std::hypot(over_r, over_z);
    slope_r = over_r / length;
    const double slope_z = over_z / length;
    distance.value = length - plate.rim_radius;
    distance.normal = slope_r * out + slope_z * up;
    AddSquare(1.0 / length, slope_z * out - slope_r * up, distance.curvature);
  } else if (over_r > over_z) {
    slope_r = 1.0;
    distance.value = over_r - plate.rim_radius;
    distance.normal = out;
  } else {
    distance.value = over_z - plate.rim_radius;
    distance.normal = up;
  }
  if (slope_r > 0.0) AddSquare(slope_r / r, around, distance.curvature);
  return distance;
}

// From a solid that is no mesh.
DRAPE_HD inline SolidDistance DistanceToFormula(const Solid& solid, const Vec3<double>& x) {
  switch (solid.kind) {
    case Solid::Kind::kSphere:
      return AwayFrom(x - solid.first, solid.size, {0.0, 0.0, 0.0});
    case Solid::Kind::kCapsule:
      return DistanceToSegment(solid.first, solid.second, solid.size, x);
    case Solid::Kind::kPlate:
      return DistanceToPlate(solid, x);
    case Solid::Kind::kPlane:
    case Solid::Kind::kMesh:
      break;
  }
  SolidDistance distance;
  distance.value = Dot(solid.first, x) - solid.size;
  distance.normal = solid.first;
  return distance;
}
DRAPE_HD inline SolidDistance DistanceTo(const Solid& solid, const Vec3<double>& x) {
  return solid.kind == Solid::Kind::kMesh ? DistanceTo(solid.surface, x)
                                          : DistanceToFormula(solid, x);
}

// Whether the distance is convex along a straight line.
DRAPE_HD inline bool IsConvex(const Solid& solid) {
  return solid.kind != Solid::Kind::kMesh || solid.surface.is_convex;
}

}  // namespace drape
