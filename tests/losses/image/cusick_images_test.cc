// SPDX-License-Identifier: Apache-2.0
// The published silhouettes [Gong 2024], read in place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>

#include "losses/image/segmentation.h"
#include "losses/metrics/metrics.h"
#include "losses/outline/outline.h"

namespace drape {
namespace {

namespace fs = std::filesystem;

constexpr int kNumAngles = 360;
constexpr double kSupport = 0.09 * 719.5;  // [px]
constexpr double kFlat = 0.15 * 719.5;     // [px]

std::vector<std::string> JpegsBelow(const std::string& folder) {
  std::vector<std::string> paths;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".jpg") paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

class CusickImages : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::is_directory(root_)) GTEST_SKIP() << "no public data set at " << root_;
  }
  const std::string root_ = DRAPE_SHARED_DIR "/cusick";
};

struct RadiusRange {
  double min, max;
  bool IsPhysical() const { return min >= kSupport - 1 && max <= 108.5; }
};

// The smallest and largest distance of the outline from `centre` [px, y up, from the camera
// centre].
RadiusRange RangeAbout(const Eigen::Matrix2Xd& outline, const Eigen::Vector2d& centre) {
  const Eigen::ArrayXd distance = (outline.colwise() - centre).colwise().norm().array();
  return {distance.minCoeff(), distance.maxCoeff()};
}

// The same about that centre on a grid of 0.25 px from which the outline least violates the bounds:
// the cloth covers the support and does not exceed its flat radius.
RadiusRange RangeAboutBestCentre(const Eigen::Matrix2Xd& outline) {
  RadiusRange best{};
  double least = 1e9;
  for (double x = -12; x <= 12; x += 0.25) {
    for (double y = -12; y <= 12; y += 0.25) {
      const RadiusRange range = RangeAbout(outline, {x, y});
      const double violation = std::max(kSupport - range.min, range.max - kFlat);
      if (violation >= least) continue;
      least = violation;
      best = range;
    }
  }
  return best;
}

// Of fabrics 1–5 and of the training images. Not every image is centred: 18 of the 300 files
// violate the bounds about the nominal centre, by up to 10 px (fabric 3, sample 7, capture 3), but
// none does about its own centre.
TEST_F(CusickImages, AllLoadAndLieBetweenSupportAndFlatCloth) {
  auto paths = JpegsBelow(root_ + "/bnn_image_gt");
  for (const char* fabric : {"1", "2", "3", "4", "5"})
    for (std::string& path : JpegsBelow(root_ + "/data/Fabric " + fabric))
      paths.push_back(std::move(path));
  EXPECT_EQ(paths.size(), 300u);
  int off_centre = 0;
  RadiusRange total{1e9, 0};
  for (const std::string& path : paths) {
    Outline outline;
    const GrayImage image = ReadSilhouette(path).image;
    ASSERT_EQ(image.width, 256) << path;
    ASSERT_EQ(image.height, 256) << path;
    ASSERT_TRUE(OutlineFromImage(image, Camera(), kNumAngles, &outline)) << path;
    const Eigen::Matrix2Xd polygon = ProfilePolygon(outline.radius);
    const RadiusRange nominal = RangeAbout(polygon, {0, 0});
    const RadiusRange centred = RangeAboutBestCentre(polygon);
    EXPECT_TRUE(centred.IsPhysical()) << path << ": " << centred.min << ", " << centred.max;
    off_centre += !nominal.IsPhysical();
    total = {std::min(total.min, nominal.min), std::max(total.max, nominal.max)};
  }
  EXPECT_EQ(off_centre, 18);
  EXPECT_NEAR(total.min, 55.3, 0.1);
  EXPECT_NEAR(total.max, 111.4, 0.1);
}

TEST_F(CusickImages, MeanDrapeCoefficientsAndFoldsOfTheFabrics) {
  const std::map<int, std::pair<double, double>> expected = {
      {2, {0.73, 7.6}}, {3, {0.15, 11.5}}, {5, {0.79, 7.6}}};  // fabric → DC, folds
  for (const auto& [fabric, published] : expected) {
    const auto paths =
        JpegsBelow(root_ + "/data/Fabric " + std::to_string(fabric) + "/silhouettes");
    ASSERT_EQ(paths.size(), 48u);
    double area_dc = 0, profile_dc = 0, folds = 0;
    for (const std::string& path : paths) {
      const GrayImage image = ReadSilhouette(path).image;
      Outline outline;
      ASSERT_TRUE(OutlineFromImage(image, Camera(), kNumAngles, &outline)) << path;
      const ShapeFeatures shape = MeasureShape(MetresFromPixels(outline.radius, Camera()), {});
      area_dc += DrapeCoefficient(CoverageArea(image, Camera()), {}) / paths.size();
      profile_dc += shape.drape_coefficient / paths.size();
      folds += double(shape.folds) / paths.size();
    }
    std::printf("fabric %d: DC by area %.4f, by profile %.4f, folds %.2f\n", fabric, area_dc,
                profile_dc, folds);
    EXPECT_NEAR(area_dc, published.first, 0.02) << "fabric " << fabric;
    EXPECT_NEAR(profile_dc, published.first, 0.02) << "fabric " << fabric;
    // The expected means were computed over a selection of captures that was not recorded.
    EXPECT_NEAR(folds, published.second, 0.4) << "fabric " << fabric;
  }
}

}  // namespace
}  // namespace drape
