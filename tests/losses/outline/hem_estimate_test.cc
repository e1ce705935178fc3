// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "losses/outline/outline.h"

namespace drape {
namespace {

TEST(EstimatedHemHeight, IsThatOfAHangingAndOfAFlatCloth) {
  EXPECT_DOUBLE_EQ(EstimatedHemHeight(0.09, {}), -0.06);
  EXPECT_DOUBLE_EQ(EstimatedHemHeight(0.15, {}), 0.0);
  EXPECT_NEAR(EstimatedHemHeight(0.12, {}), -0.06 * std::sqrt(0.9775 * 0.9775 - 0.25), 1e-12);
  EXPECT_NEAR(EstimatedHemHeight(0.12, {0.18, 0.09}), -0.0842, 2e-3);
}

// Straight above the axis at 1 m, where a point at the height z is seen at radius·(1 − z/1 m).
TEST(EstimatedOutermost, IsTheHemFarFromTheSupportAndBetweenItAndTheBendNearIt) {
  const auto seen_at = [](double radius, double height) {
    const double at_support = radius / (1 - height);
    return [at_support](double z) { return Eigen::Vector2d(at_support * (1 - z), 0.0); };
  };
  for (const double radius : {0.11, 0.13, 0.15}) {
    const auto point_at = seen_at(radius, EstimatedHemHeight(radius, {}));
    EXPECT_NEAR(EstimatedOutermost(point_at, {}).x(), radius, 1e-5) << radius;
  }
  const double rim = 0.09;
  const Eigen::Vector2d found = EstimatedOutermost(seen_at(rim, 0.0), {});
  EXPECT_GT(found.x(), rim);
  EXPECT_LT(found.x(), rim * (1 - EstimatedHemHeight(rim, {})));
  EXPECT_NEAR(EstimatedOutermost(seen_at(1.02 * rim, 0.0), {}).x(), 1.02 * rim * 1.0117, 1e-4);
}

// A hem that hangs exactly at the estimated heights is found again.
TEST(VerticalProfile, UndoesAnObliquePinhole) {
  Camera camera;
  camera.kind = CameraKind::kPinhole;
  camera.width = 1200;
  camera.height = 1000;
  camera.cx = 640;
  camera.cy = 510;
  camera.eye_height = 1.0;
  camera.eye_x = 0.08;
  camera.eye_y = -0.05;
  constexpr int kAngles = 360, kFine = 3600;
  const auto radius = [](double angle) { return 0.12 + 0.012 * std::cos(7 * angle + 0.4); };
  Eigen::VectorXd seen = Eigen::VectorXd::Zero(kAngles);
  Eigen::Matrix2Xd points(2, kFine);
  for (int i = 0; i < kFine; ++i) {
    const double angle = 2 * M_PI * i / kFine, r = radius(angle);
    const double x[3] = {r * std::cos(angle), r * std::sin(angle), EstimatedHemHeight(r, {})};
    camera.Project(x, points.col(i).data());
  }
  for (int i = 0; i < kFine; ++i) {
    const double angle = std::atan2(camera.cy - points(1, i), points(0, i) - camera.cx);
    const int k = static_cast<int>(std::lround(angle / (2 * M_PI) * kAngles) + kAngles) % kAngles;
    if (std::abs(std::remainder(angle - 2 * M_PI * k / kAngles, 2 * M_PI)) < M_PI / kFine)
      seen[k] = std::hypot(points(0, i) - camera.cx, points(1, i) - camera.cy);
  }
  for (int k = 0; k < kAngles; ++k)
    if (seen[k] == 0) seen[k] = seen[(k + kAngles - 1) % kAngles];
  const Eigen::VectorXd found = VerticalProfile(seen, camera, {});
  const Eigen::VectorXd plane = MetresFromPixels(seen, camera);
  double worst = 0;
  for (int k = 0; k < kAngles; ++k)
    worst = std::max(worst, std::abs(found[k] - radius(2 * M_PI * k / kAngles)));
  EXPECT_LT(worst, 2.5e-3);
  EXPECT_NEAR(ProfileArea(found), M_PI * (0.12 * 0.12 + 0.5 * 0.012 * 0.012), 2e-4);
  EXPECT_LT(ProfileArea(plane), 0.95 * ProfileArea(found));
}

}  // namespace
}  // namespace drape
