// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/render.h"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

namespace drape {
namespace {

using Colour = std::array<uint8_t, 3>;

Colour At(const RgbImage& image, int column, int row) {
  const uint8_t* rgb = &image.rgb[3 * (size_t(row) * image.width + column)];
  return {rgb[0], rgb[1], rgb[2]};
}

// Two squares of 1 m that face −y: the left half of a picture of the front at depth `left`, both
// halves at depth 0.
struct RenderCase {
  std::vector<std::array<int, 3>> square = {{0, 1, 2}, {0, 2, 3}};
  Eigen::VectorXd wide{{-.5, 0, -.5, .5, 0, -.5, .5, 0, .5, -.5, 0, .5}};
  Eigen::VectorXd half;
  explicit RenderCase(double left)
      : half{{-.5, left, -.5, 0, left, -.5, 0, left, .5, -.5, left, .5}} {}
};

constexpr Colour kRed = {200, 0, 0}, kGreen = {0, 200, 0}, kBlue = {0, 0, 200};

View Front() { return {0, 0, {0, 0, 0}, 2, 40, 40}; }

TEST(Render, TheNearerSurfaceHidesTheFarther) {
  for (const double depth : {-.1, .1}) {
    const RenderCase scene(depth);
    const std::vector<ShownSurface> surfaces = {{&scene.square, &scene.wide, kRed, kBlue},
                                                {&scene.square, &scene.half, kGreen, kBlue}};
    const RgbImage image = RenderSurfaces(surfaces, Front());
    EXPECT_EQ(At(image, 2, 20), (Colour{255, 255, 255}));
    EXPECT_EQ(At(image, 15, 20)[1] > 0, depth < 0);
    EXPECT_EQ(At(image, 15, 20)[0] > 0, depth > 0);
    EXPECT_GT(At(image, 25, 20)[0], 50);
  }
}

TEST(Render, TheBackHasItsColour) {
  const RenderCase scene(0);
  View back = Front();
  back.azimuth = 180;
  const RgbImage image = RenderSurfaces({{&scene.square, &scene.half, kRed, kBlue}}, back);
  EXPECT_EQ(At(image, 25, 20)[0], 0);  // the left half is on the right from behind
  EXPECT_GT(At(image, 25, 20)[2], 50);
  EXPECT_EQ(At(image, 15, 20), (Colour{255, 255, 255}));
}

TEST(Render, HasTheScaleOfTheView) {
  const RenderCase scene(0);
  const RgbImage image = RenderSurfaces({{&scene.square, &scene.wide, kRed, kBlue}}, Front());
  int covered = 0;
  for (int row = 0; row < 40; ++row)
    for (int column = 0; column < 40; ++column) covered += At(image, column, row)[1] == 0;
  EXPECT_EQ(covered, 20 * 20);  // 1 m of 2 m
}

TEST(Render, TilesPicturesInRows) {
  const RgbImage black{2, 1, std::vector<uint8_t>(6, 0)};
  const RgbImage sheet = TilePictures({black, black, black}, 2);
  EXPECT_EQ(sheet.width, 8);
  EXPECT_EQ(sheet.height, 6);
  EXPECT_EQ(At(sheet, 7, 0), (Colour{0, 0, 0}));
  EXPECT_EQ(At(sheet, 3, 0), (Colour{255, 255, 255}));
  EXPECT_EQ(At(sheet, 1, 5), (Colour{0, 0, 0}));
  EXPECT_EQ(At(sheet, 7, 5), (Colour{255, 255, 255}));
}

}  // namespace
}  // namespace drape
