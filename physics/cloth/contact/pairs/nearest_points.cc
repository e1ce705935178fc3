// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/nearest_points.h"

#include <algorithm>

namespace drape {

Eigen::Vector3d NearestWeights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return {1.0, 0.0, 0.0};
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return {0.0, 1.0, 0.0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {1.0 - d1 / (d1 - d3), d1 / (d1 - d3), 0.0};
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return {0.0, 0.0, 1.0};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {1.0 - d2 / (d2 - d6), 0.0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4, along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return {0.0, 1.0 - along, along};
  const double sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

Eigen::Vector2d NearestPositions(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& c, const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = b - a, v = d - c, w = a - c;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  const double uw = u.dot(w), vw = v.dot(w), determinant = uu * vv - uv * uv;
  const auto share = [](double number, double of) {
    return of > 0.0 ? std::clamp(number / of, 0.0, 1.0) : 0.0;
  };
  const double s = determinant > 1e-14 * uu * vv ? share(uv * vw - vv * uw, determinant) : 0.0;
  const double t = s * uv + vw;
  if (t <= 0.0) return {share(-uw, uu), 0.0};
  if (t >= vv) return {share(uv - uw, uu), 1.0};
  return {s, t / vv};
}

}  // namespace drape
