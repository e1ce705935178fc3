// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <variant>

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

}  // namespace drape
