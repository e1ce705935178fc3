// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/nearest_points.h"

#include <algorithm>

namespace drape {

Eigen::Vector3d NearestWeights(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                               const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const auto plain = [](const Eigen::Vector3d& v) { return Vec3<double>{v.x(), v.y(), v.z()}; };
  const Vec3<double> weights = NearestWeights(plain(p), plain(a), plain(b), plain(c));
  return {weights.x, weights.y, weights.z};
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
