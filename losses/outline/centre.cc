// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/centre.h"

#include <cmath>
#include <numbers>

#include "losses/outline/outline.h"

namespace drape {

bool CentreOnOutline(const GrayImage& image, Camera* camera) {
  constexpr int kAngles = 360, kMaxRounds = 20;
  constexpr double kTolerance = 1e-4;  // [px]
  for (int round = 0; round < kMaxRounds; ++round) {
    Outline outline;
    if (!OutlineFromImage(image, *camera, kAngles, &outline)) return false;
    double along = 0.0, up = 0.0;
    for (int k = 0; k < kAngles; ++k) {
      const double theta = 2.0 * std::numbers::pi * k / kAngles;
      along += 2.0 / kAngles * outline.radius[k] * std::cos(theta);
      up += 2.0 / kAngles * outline.radius[k] * std::sin(theta);
    }
    camera->cx += along;
    camera->cy -= up;
    if (std::hypot(along, up) < kTolerance) break;
  }
  return true;
}

void CentreOnFarCloth(const GrayImage& image, Camera* camera) {
  double area = 0.0, column = 0.0, row = 0.0;
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      area += image.at(c, r);
      column += static_cast<double>(image.at(c, r)) * c;
      row += static_cast<double>(image.at(c, r)) * r;
    }
  }
  column /= area;
  row /= area;
  const double mean_radius = std::sqrt(area / std::numbers::pi);
  if (!(std::hypot(column - camera->cx, row - camera->cy) > mean_radius / 3)) return;
  camera->cx = column;
  camera->cy = row;
}

}  // namespace drape
