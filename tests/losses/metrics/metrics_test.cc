// SPDX-License-Identifier: Apache-2.0
#include "losses/metrics/metrics.h"

#include <gtest/gtest.h>

#include "losses/outline/outline.h"
#include "losses/silhouette/silhouette.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

Eigen::VectorXd Profile(int num_angles, double mean, double amplitude, int order,
                        double phase = 0) {
  return Eigen::VectorXd::NullaryExpr(num_angles, [&](Eigen::Index k) {
    return mean + amplitude * std::cos(order * (2 * M_PI * k / num_angles - phase));
  });
}

TEST(DrapeCoefficient, IsZeroForTheSupportAndOneForTheFlatCloth) {
  EXPECT_NEAR(DrapeCoefficient(M_PI * 0.09 * 0.09, {}), 0, 1e-14);
  EXPECT_NEAR(DrapeCoefficient(M_PI * 0.15 * 0.15, {}), 1, 1e-14);
}

TEST(ProfileArea, OfCircleAndFoldedCircle) {
  EXPECT_NEAR(ProfileArea(Profile(72, 0.12, 0, 0)), M_PI * 0.12 * 0.12, 1e-15);
  // ½∫(m + a cos)² = π(m² + a²/2)
  EXPECT_NEAR(ProfileArea(Profile(72, 0.12, 0.02, 7)), M_PI * (0.12 * 0.12 + 0.0002), 1e-15);
}

class FoldCount : public testing::TestWithParam<int> {};
TEST_P(FoldCount, OfACosine) {
  const int folds = GetParam();
  for (double phase : {0.0, 0.1, 1.7}) {
    for (int num_angles : {180, 360, 719}) {
      const Eigen::VectorXd r = Profile(num_angles, 0.12, 0.008, folds, phase);
      EXPECT_EQ(CountFolds(r), folds) << num_angles << " angles, phase " << phase;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(From0To12, FoldCount, testing::Range(0, 13));

TEST(CountFolds, NeedsTheProminence) {
  // The prominence of a cosine is 2·amplitude; the smoothing reduces it by 2 % at order 6.
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 1.32e-3, 6)), 6);
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 1.20e-3, 6)), 0);
}

TEST(CountFolds, IgnoresNoiseButNotANotchedPeak) {
  const Eigen::VectorXd noise = 3e-4 * RandomVector(360, 3);
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 0.01, 7) + noise), 7);
  // There are two unequal peaks in each period of 3; the small one of prominence 2a(…) counts as
  // well.
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 0.006, 3) + Profile(360, 0, 0.006, 6)), 6);
  EXPECT_EQ(CountFolds(Profile(360, 0.12, 0.006, 3) + Profile(360, 0, 0.001, 6)), 3);
}

TEST(BandEnergies, AreTheSharesOfTheVariance) {
  const Eigen::VectorXd r = Profile(180, 0.12, 0.01, 2, 0.3) + Profile(180, 0, 0.004, 4) +
                            Profile(180, 0, 0.003, 5) + Profile(180, 0, 0.006, 9) +
                            Profile(180, 0, 0.002, 10) + Profile(180, 0, 0.02, 16);
  const auto energy = BandEnergies(r);
  EXPECT_NEAR(energy[0], 0.5e-4, 1e-16);
  EXPECT_NEAR(energy[1], 0.5 * (16e-6 + 9e-6), 1e-16);
  EXPECT_NEAR(energy[2], 0.5 * 36e-6, 1e-16);
  EXPECT_NEAR(energy[3], 0.5 * 4e-6, 1e-16);
}

TEST(IsoperimetricRatio, IsOneForACircleOnly) {
  // A regular N-gon has (π/N)/tan(π/N).
  EXPECT_NEAR(IsoperimetricRatio(Profile(360, 0.12, 0, 0)), M_PI / 360 / std::tan(M_PI / 360),
              1e-12);
  // A closed form: a square in polar coordinates, r = 1/max(|cos|, |sin|), has π/4.
  const Eigen::VectorXd square = Eigen::VectorXd::NullaryExpr(720, [](Eigen::Index k) {
    const double angle = 2 * M_PI * k / 720;
    return 1 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
  });
  EXPECT_NEAR(IsoperimetricRatio(square), M_PI / 4, 1e-12);
}

TEST(ImageMetrics, OfHalfOverlappingBars) {
  GrayImage a(20, 20), b(20, 20);
  for (int i = 0; i < 20; ++i) {
    for (int col = 2; col < 6; ++col) a.at(col, i) = 1;
    for (int col = 4; col < 8; ++col) b.at(col, i) = 0.75f;
  }
  EXPECT_NEAR(IntersectionOverUnion(a, b), 2.0 / 6, 1e-15);
  EXPECT_NEAR(IntersectionOverUnion(a, b, 0.8f), 0, 1e-15);
  EXPECT_NEAR(MeanSquaredError(a, b), (2 * 1 + 2 * 0.0625 + 2 * 0.5625) / 20, 1e-15);
  EXPECT_EQ(IntersectionOverUnion(GrayImage(20, 20), GrayImage(20, 20)), 1);
}

TEST(ProfileRms, OfAConstantOffset) {
  EXPECT_NEAR(ProfileRms(Profile(72, 100, 5, 3), Profile(72, 98, 5, 3)), 2, 1e-12);
}

TEST(CompareSilhouettes, TwoCirclesInClosedForm) {
  const Camera camera;
  const double small = 0.11, large = 0.13;
  const auto image_of = [&](double radius) {
    const Mesh disc = MakeDisc(3, 360, radius);
    return Rasterize(disc, disc.rest_x, camera, 8);
  };
  const GrayImage image = image_of(large), fit = image_of(small);
  Outline outline;
  ASSERT_TRUE(OutlineFromImage(image, camera, 360, &outline));
  const SilhouetteMetrics m = CompareSilhouettes(
      image, outline.radius, fit, Eigen::VectorXd::Constant(360, small * camera.scale), camera, {});
  const double ring = M_PI * (large * large - small * small);
  // A border pixel of coverage c contributes c² where the area of the ring contributes c: ∫(c − c²)
  // = 1/6 px per border px.
  const double border = 2 * M_PI * (large + small) * camera.scale;
  const double mse = (ring * camera.scale * camera.scale - border / 6) / (256 * 256);
  EXPECT_NEAR(m.mse, mse, 3e-4);
  EXPECT_NEAR(m.iou, small * small / (large * large), 5e-3);
  EXPECT_NEAR(m.profile_rms, 0.02 * camera.scale, 0.05);
  EXPECT_NEAR(m.hausdorff, 0.02, 2e-4);
  EXPECT_NEAR(m.image_area_dc, DrapeCoefficient(M_PI * large * large, {}), 1e-3);
  EXPECT_NEAR(m.fitted_area_dc, DrapeCoefficient(M_PI * small * small, {}), 1e-3);
  EXPECT_NEAR(m.image.drape_coefficient, m.image_area_dc, 2e-3);
  EXPECT_NEAR(m.fitted.drape_coefficient, DrapeCoefficient(M_PI * small * small, {}), 1e-12);
  EXPECT_EQ(m.image.folds, 0);
  EXPECT_NEAR(m.image.radius_min, large, 2e-4);
  EXPECT_NEAR(m.image.radius_max, large, 2e-4);
  EXPECT_GT(m.image.isoperimetric_ratio, 0.99);
}

}  // namespace
}  // namespace drape
