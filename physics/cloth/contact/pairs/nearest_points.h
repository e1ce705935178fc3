// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/util/math/vec3.h"

namespace drape {

// The weights of the corners a, b, c at the point of their triangle that is nearest to p
// [Ericson 2005, 5.1.5]. Exactly 0 for corners that an edge or a corner leaves out.
Eigen::Vector3d NearestWeights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, const Eigen::Vector3d& c);
// These weights for host and device.
DRAPE_HD inline Vec3<double> NearestWeights(const Vec3<double>& p, const Vec3<double>& a,
                                            const Vec3<double>& b, const Vec3<double>& c) {
  const Vec3<double> ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = Dot(ab, ap), d2 = Dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const double d3 = Dot(ab, bp), d4 = Dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
  const double d5 = Dot(ab, cp), d6 = Dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4, along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return {0.0, 1.0 - along, along};
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

// The positions s, t in [0, 1] along the segments a–b and c–d of their points nearest to one
// another [Ericson 2005, 5.1.9]; of parallel ones, some such pair.
Eigen::Vector2d NearestPositions(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c, const Eigen::Vector3d& d);

}  // namespace drape
