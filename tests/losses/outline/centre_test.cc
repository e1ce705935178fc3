// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "losses/outline/outline.h"

namespace drape {
namespace {

// A star of 7 folds with an ellipse, without a first harmonic about (column, row). The coverage
// falls from 1 to 0 over the pixel that the outline crosses.
GrayImage Star(double column, double row) {
  GrayImage image(256, 256);
  for (int j = 0; j < image.height; ++j) {
    for (int i = 0; i < image.width; ++i) {
      const double x = i - column, y = row - j, angle = std::atan2(y, x);
      const double radius =
          80.0 + 9.0 * std::cos(7 * angle + 0.4) + 5.0 * std::cos(2 * angle - 1.0);
      image.at(i, j) = static_cast<float>(std::clamp(radius - std::hypot(x, y) + 0.5, 0.0, 1.0));
    }
  }
  return image;
}

class CentreTest : public testing::TestWithParam<std::pair<double, double>> {};
INSTANTIATE_TEST_SUITE_P(Offsets, CentreTest,
                         testing::Values(std::pair{0.0, 0.0}, std::pair{9.5, 0.0},
                                         std::pair{0.0, -7.25}, std::pair{-6.3, 8.1}));

TEST_P(CentreTest, FindsAKnownOffset) {
  const auto [along, down] = GetParam();
  Camera camera;
  const Camera nominal;
  ASSERT_TRUE(CentreOnOutline(Star(nominal.cx + along, nominal.cy + down), &camera));
  EXPECT_NEAR(camera.cx - nominal.cx, along, 0.05);
  EXPECT_NEAR(camera.cy - nominal.cy, down, 0.05);
  EXPECT_EQ(camera.scale, nominal.scale);
}

TEST(Centre, LeavesNoFirstHarmonic) {
  const GrayImage image = Star(134.0, 121.0);
  Camera camera;
  ASSERT_TRUE(CentreOnOutline(image, &camera));
  Outline outline;
  ASSERT_TRUE(OutlineFromImage(image, camera, 360, &outline));
  double along = 0.0, up = 0.0;
  for (int k = 0; k < 360; ++k) {
    along += outline.radius[k] * std::cos(2 * M_PI * k / 360) / 180;
    up += outline.radius[k] * std::sin(2 * M_PI * k / 360) / 180;
  }
  EXPECT_LT(std::hypot(along, up), 1e-3);
}

TEST(Centre, AnImageWithoutClothHasNone) {
  Camera camera;
  EXPECT_FALSE(CentreOnOutline(GrayImage(256, 256), &camera));
}

}  // namespace
}  // namespace drape
