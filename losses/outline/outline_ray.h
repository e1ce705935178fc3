// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "losses/camera/projection.h"

namespace drape {

// The radial profile of a projected hem, ray by ray [MODEL, M47], in one source for the host and
// the kernels. Points of the hem are in pixels about the camera centre, y up.

// The segment of the projected hem between two vertices through which the ray of one angle leaves.
struct OutlineHit {
  int vertex[2] = {-1, -1};  // −1: the ray met nothing
  double d_radius[6] = {};   // ∂r/∂(x of vertex[0], x of vertex[1]) [px/m]
};

// Projects a point of the hem [px]. Returns false when it is not finite or not in front of the
// camera.
DRAPE_HD inline bool ProjectHemPoint(const Projection& camera, const double x[3], Vec2* point) {
  double image[2];
  camera.Project(x, image);
  *point = {image[0] - camera.cx, camera.cy - image[1]};
  return camera.IsInFront(x) && std::isfinite(point->x) && std::isfinite(point->y) &&
         std::isfinite(x[2]);
}

// The direction of ray k of num_angles.
DRAPE_HD inline Vec2 RayDirection(int k, int num_angles) {
  const double angle = 2 * M_PI * k / num_angles;
  return {std::cos(angle), std::sin(angle)};
}

// The outermost crossing of a ray so far.
struct RayCrossing {
  int segment = -1;  // of the hem, from its point `segment` to the next one; -1: none
  double t = 0;      // position on it
  double radius = 0;
};

// Records the segment a→b of the hem if it is the outermost crossing so far. A vertex lies on the
// same side of a ray in both of its segments (half-open rule), so that no ray passes between two
// segments.
DRAPE_HD inline void CrossRay(const Vec2& ray, const Vec2& a, const Vec2& b, int segment,
                              RayCrossing* outermost) {
  const double side_a = Cross(ray, a), side_b = Cross(ray, b);
  if ((side_a > 0) == (side_b > 0)) return;
  const double t = side_a / (side_a - side_b);
  const double radius = Dot(ray, a + t * (b - a));
  if (radius > outermost->radius) *outermost = {segment, t, radius};
}

// ∂r of the crossing at a + t(b − a), with edge = b − a [MODEL, M47]: the normal of the segment
// over its component along the ray, distributed to the ends at x_a and x_b [m].
DRAPE_HD inline void RadiusByEnds(const Projection& camera, const Vec2& ray, const Vec2& edge,
                                  double t, const double* x_a, const double* x_b,
                                  double d_radius[6]) {
  const double across = Cross(ray, edge);
  const Vec2 by_image{edge.y / across, edge.x / across};  // rows of the image run down
  camera.AdjProject(x_a, (1 - t) * by_image, d_radius);
  camera.AdjProject(x_b, t * by_image, d_radius + 3);
}

}  // namespace drape
