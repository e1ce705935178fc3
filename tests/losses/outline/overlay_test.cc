// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "losses/outline/measured_image.h"
#include "losses/silhouette/silhouette.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

Color At(const RgbImage& picture, int column, int row) {
  const uint8_t* rgb = &picture.rgb[3 * (size_t(row) * picture.width + column)];
  return {rgb[0], rgb[1], rgb[2]};
}

void ExpectColor(const Color& found, const Color& expected) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 2) << "channel " << c;
}

TEST(RenderOverlay, PaintsEachLineAtItsRadius) {
  const Mesh disc = MakeDisc(3, 240, 0.13);
  const Camera camera;
  const GrayImage image = Rasterize(disc, disc.rest_x, camera);
  const RgbImage picture = RenderOverlay(image, Eigen::VectorXd::Constant(1440, 93.5),
                                         Eigen::VectorXd::Constant(1440, 80.0), camera, {});
  ASSERT_EQ(picture.width, 768);
  ASSERT_EQ(picture.height, 768);
  // To the right of the centre; the column of radius r is 3·(127.5 + r + ½) − ½.
  const int row = 384;
  ExpectColor(At(picture, int(3 * (128 + 93.5)), row), kMeasuredColor);
  ExpectColor(At(picture, int(3 * (128 + 80.0)), row), kFittedColor);
  EXPECT_EQ(At(picture, 384, row), (Color{150, 150, 150}));  // cloth
  EXPECT_EQ(At(picture, 760, row), (Color{255, 255, 255}));  // background
  const Color support = At(picture, int(std::lround(3 * (128 + 64.755) - 0.5)), row);
  EXPECT_LT(support[0], 140);
}

TEST(RenderOverlay, LinesThatLeaveTheImageAreCut) {
  const RgbImage picture = RenderOverlay(GrayImage(64, 48), Eigen::VectorXd::Constant(8, 1e6),
                                         Eigen::VectorXd::Constant(8, 500), Camera(), {});
  EXPECT_EQ(picture.rgb.size(), 3u * 192 * 144);
}

}  // namespace
}  // namespace drape
