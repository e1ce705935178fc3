// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/hem_estimate.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "losses/outline/outline_ray.h"
#include "losses/outline/shape_features.h"

namespace drape {
namespace {

constexpr double kShortening = 0.09;
constexpr int kRounds = 12;
constexpr double kRim = 1.02;  // of the support's radius, up to which its rim is seen

// Where the hem that is seen at an image point hangs [m], by iteration of its height. The support
// hides a hem that is nearer to the axis in the image: there its rim is what is seen.
Eigen::Vector2d HemPoint(const Eigen::Vector2d& image, const Camera& camera,
                         const DrapeDiscs& discs) {
  Eigen::Vector2d point = camera.WorldFromImage(image, 0.0);
  if (point.norm() < kRim * discs.support) return point;
  double z = 0.5 * EstimatedHemHeight(discs.support, discs);
  point = camera.WorldFromImage(image, z);
  for (int round = 0; round < kRounds; ++round) {
    z = 0.5 * (z + EstimatedHemHeight(point.norm(), discs));
    point = camera.WorldFromImage(image, z);
  }
  return point;
}

// The profile of a closed polygon about the origin at K equal angles.
Eigen::VectorXd ProfileOfPolygon(const std::vector<Vec2>& polygon, int num_angles) {
  Eigen::VectorXd radius(num_angles);
  for (int k = 0; k < num_angles; ++k) {
    const Vec2 ray = RayDirection(k, num_angles);
    RayCrossing outermost;
    for (size_t i = 0; i < polygon.size(); ++i)
      CrossRay(ray, polygon[i], polygon[(i + 1) % polygon.size()], static_cast<int>(i), &outermost);
    radius[k] = outermost.radius;
  }
  return radius;
}

}  // namespace

double EstimatedHemHeight(double r, const DrapeDiscs& discs) {
  const double free_length = discs.specimen - discs.support;
  const double u = std::clamp((r - discs.support) / free_length, 0.0, 1.0);
  const double chord = 1.0 - kShortening * u * (1.0 - u);
  return -free_length * std::sqrt(std::max(chord * chord - u * u, 0.0));
}

Eigen::VectorXd VerticalProfile(const Eigen::VectorXd& radius_px, const Camera& camera,
                                const DrapeDiscs& discs) {
  CHECK_GE(radius_px.size(), 8);
  if (camera.kind == CameraKind::kOrthographic) return MetresFromPixels(radius_px, camera);
  const int num_angles = static_cast<int>(radius_px.size());
  std::vector<Vec2> hem;
  for (int k = 0; k < num_angles; ++k) {
    const Vec2 ray = RayDirection(k, num_angles);
    const Eigen::Vector2d point = HemPoint(
        {camera.cx + radius_px[k] * ray.x, camera.cy - radius_px[k] * ray.y}, camera, discs);
    hem.push_back({point.x(), point.y()});
  }
  return ProfileOfPolygon(hem, num_angles);
}

}  // namespace drape
