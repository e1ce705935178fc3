// SPDX-License-Identifier: Apache-2.0
#include "losses/image/disc.h"

#include <gmock/gmock.h>

#include <cmath>

#include "losses/image/photo_planes.h"

namespace drape {
namespace {

constexpr double kColumn = 80.3, kRow = 71.8, kRadius = 50.4;  // [px]

uint8_t StoredByte(double light) {
  return static_cast<uint8_t>(std::lround(255 * StoredFromLight(light)));
}

// A round disc that a lens has blurred; the ground becomes lighter with the distance from it.
RgbImage DiscPicture(double inside, double outside, double blur, double slope) {
  RgbImage image{160, 144, {}};
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const double t = std::hypot(col - kColumn, row - kRow) - kRadius;
      const double after = 0.5 * std::erfc(-t / (std::sqrt(2.0) * blur));
      const double light =
          (1 - after) * inside + after * (outside + slope * std::clamp(t, -8.0, 8.0));
      for (const double tint : {1.0, 0.9, 0.8}) image.rgb.push_back(StoredByte(tint * light));
    }
  return image;
}

struct Lighting {
  double inside, outside, slope;
};
class Rim : public testing::TestWithParam<Lighting> {};

TEST_P(Rim, IsFoundToTwoHundredthsOfAPixel) {
  const auto [inside, outside, slope] = GetParam();
  for (const double blur : {0.7, 1.2, 2.0}) {
    const RgbImage image = DiscPicture(inside, outside, blur, slope);
    // As from a coarse search: off by a pixel.
    const RimPoints rim = LocateRim(image, {{81.0f, 72.5f}, {99.0f, 101.5f}, 10});
    ASSERT_GT(rim.points.size(), 700u);
    double mean = 0.0, square = 0.0;
    for (const Eigen::Vector2d& p : rim.points) {
      const double error = std::hypot(p.x() - kColumn, p.y() - kRow) - kRadius;
      mean += error / double(rim.points.size());
      square += error * error / double(rim.points.size());
    }
    EXPECT_NEAR(mean, 0, 0.02) << "blur " << blur;
    EXPECT_LT(std::sqrt(square), 0.05) << "blur " << blur;
    EXPECT_NEAR(rim.blur, blur, 0.25 * blur);
  }
}

INSTANTIATE_TEST_SUITE_P(Lightings, Rim,
                         testing::Values(Lighting{0.7, 0.04, 0.0}, Lighting{0.03, 0.6, 0.0},
                                         Lighting{0.7, 0.1, 0.01}, Lighting{0.03, 0.3, -0.02}));

// The rim of a clear disc is a dark line, 3 px wide: the disc ends where the line does.
TEST(ClearDisc, EndsAtTheOuterEdgeOfItsLine) {
  const RgbImage inner = DiscPicture(0.6, 0.3, 0.9, 0), outer = DiscPicture(0.3, 0.65, 0.9, 0);
  RgbImage image = outer;
  constexpr int kWidth = 3;  // [px] by which the inner edge is moved inwards
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const double x = col - kColumn, y = row - kRow, r = std::hypot(x, y);
      if (r > kRadius - 0.5 * kWidth) continue;
      const int c = int(std::lround(kColumn + x * (r + kWidth) / std::max(r, 1.0)));
      const int w = int(std::lround(kRow + y * (r + kWidth) / std::max(r, 1.0)));
      for (int k = 0; k < 3; ++k)
        image.rgb[3 * (size_t(row) * image.width + col) + k] =
            inner.rgb[3 * (size_t(w) * image.width + c) + k];
    }
  const RimPoints rim = LocateRim(image, {{80.3f, 71.8f}, {95.0f, 95.0f}, 0});
  EXPECT_TRUE(rim.is_line);
  ASSERT_GT(rim.points.size(), 600u);
  double mean = 0.0;
  for (const Eigen::Vector2d& p : rim.points)
    mean += (std::hypot(p.x() - kColumn, p.y() - kRow) - kRadius) / double(rim.points.size());
  EXPECT_NEAR(mean, 0, 0.3);
}

TEST(StepFinder, TellsWhereThereIsNoStep) {
  const Eigen::Index count = StepFinder::CountSamples(7, 0.5);
  const StepFinder finder(7, 0.5, 1.0);
  Eigen::VectorXd samples(count);
  for (Eigen::Index i = 0; i < count; ++i) samples[i] = std::tanh(0.5 * double(i - count + 2));
  EXPECT_TRUE(finder.Find(samples).at_limit);
}

}  // namespace
}  // namespace drape
