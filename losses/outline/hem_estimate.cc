// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/hem_estimate.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "losses/outline/outline.h"
#include "losses/outline/shape_features.h"

namespace drape {
namespace {

constexpr double kShortening = 0.09;
constexpr int kRounds = 12;
// Shares of the support's radius, as seen at its height. Up to kBend the outline is mostly the bend
// of the cloth over the support, which hides the hem; from kHem on it is the hem. kLeastHems: the
// share of hems up to kBend.
constexpr double kBend = 1.02, kHem = 1.065;
constexpr double kLeastHems = 0.2;

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

Eigen::Vector2d EstimatedOutermost(const std::function<Eigen::Vector2d(double)>& point_at,
                                   const DrapeDiscs& discs) {
  const Eigen::Vector2d bend = point_at(0.0);
  double z = 0.5 * EstimatedHemHeight(discs.support, discs);
  Eigen::Vector2d hem = point_at(z);
  for (int round = 0; round < kRounds; ++round) {
    z = 0.5 * (z + EstimatedHemHeight(hem.norm(), discs));
    hem = point_at(z);
  }
  const double from_bend = (bend.norm() / discs.support - kBend) / (kHem - kBend);
  const double hems = kLeastHems + (1 - kLeastHems) * std::clamp(from_bend, 0.0, 1.0);
  return bend + hems * (hem - bend);
}

Eigen::VectorXd VerticalProfile(const Eigen::VectorXd& radius_px, const Camera& camera,
                                const DrapeDiscs& discs) {
  CHECK_GE(radius_px.size(), 8);
  if (camera.kind == CameraKind::kOrthographic) return MetresFromPixels(radius_px, camera);
  const int num_angles = static_cast<int>(radius_px.size());
  std::vector<Vec2> hem;
  for (int k = 0; k < num_angles; ++k) {
    const Vec2 ray = RayDirection(k, num_angles);
    const Eigen::Vector2d image(camera.cx + radius_px[k] * ray.x, camera.cy - radius_px[k] * ray.y);
    const Eigen::Vector2d point =
        EstimatedOutermost([&](double z) { return camera.WorldFromImage(image, z); }, discs);
    hem.push_back({point.x(), point.y()});
  }
  return ProfileOfPolygon(hem, num_angles);
}

}  // namespace drape
