// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "physics/mesh/obj_io.h"

namespace drape {

inline constexpr double kWrapGap = .015, kWrapOffset = .002;  // [m]

// A closed surface without self-intersections around any triangles [Portaneri 2022]: kWrapOffset
// outside of them, over every cleft into which no ball of radius kWrapGap fits. Holes are closed
// before. x within 10 m.
ObjSurface Wrap(const ObjSurface& surface);

// Carries points along with a surface: each moves with the triangle that is nearest to it at first.
class Follower {
 public:
  // points: [m], shape [3N].
  Follower(const ObjSurface& surface, const Eigen::VectorXd& points);
  // The points, shape [3N], when the vertices of the surface are at x, shape [3V] [m].
  Eigen::VectorXd At(const Eigen::VectorXd& x) const;

 private:
  std::vector<std::array<int, 3>> triangles_;  // of each point
  Eigen::Matrix3Xd place_;                     // in the frame of its triangle
};

inline constexpr double kPartGap = .012;  // between parts of a body that face one another [m]

// Presses in the closed surface of a person, z up, where parts of it face one another, such as
// thighs, or meet, so that cloth fits between them: by at most kPartGap, and not the head. Returns
// the most that a vertex moves [m].
double PressIn(ObjSurface& surface);

// The vertices of a closed surface after one implicit step of its mean curvature flow [Desbrun
// 1999], which draws limbs of a radius below `length` [m] together to their axes: shape [3V].
Eigen::VectorXd Contract(const ObjSurface& surface, double length);

inline Eigen::Vector3d Vertex(const Eigen::VectorXd& x, int i) { return x.segment<3>(3 * i); }

// A limb of this radius is drawn together to half of it or less [m].
inline constexpr double kLimb = .17;

// Rises from 0 at s ≤ 0 to 1 at s ≥ 1, with two continuous derivatives.
double SmoothStep(double s);

}  // namespace drape
