// SPDX-License-Identifier: Apache-2.0
// Photographs as they come: none is measured wrongly without a word. Each kind has the fault that
// is expected of it, or is measured within half a point.
#include <gmock/gmock.h>

#include <functional>

#include "tests/losses/photo/rendered/photo_file.h"
#include "tests/losses/photo/rendered/photo_trial.h"

namespace drape {
namespace {

using Eigen::Vector3d;

const KnownDrape& Shirt() {
  static const KnownDrape drape = SimulateDrape("synthetic_shirt", 2);
  return drape;
}

PhotoScene TelephoneScene() {
  PhotoScene scene;
  scene.width = 1200;
  scene.height = 900;
  scene.focal_35mm = 32;
  scene.tilt = {0.04, -0.03};
  scene.eye = {-0.03, -0.05, 1.0};
  return scene;
}

struct Kind {
  const char* name;
  PhotoFault fault;
  std::function<void(PhotoScene&, PhotoOptions&)> spoil;
  std::function<void(RgbImage&)> edit = [](RgbImage&) {};
};

void Fill(RgbImage* image, int first_row, int end_row, uint8_t level) {
  std::fill(image->rgb.begin() + 3L * image->width * first_row,
            image->rgb.begin() + 3L * image->width * end_row, level);
}

ScenePatch Rectangle(const Rgb& color, double x0, double x1, double y0, double y1, double z) {
  return {color,
          {Vector3d(x0, y0, z), Vector3d(x1, y0, z), Vector3d(x1, y1, z), Vector3d(x0, y1, z)}};
}

class PhotoKinds : public testing::TestWithParam<Kind> {};

TEST_P(PhotoKinds, AreMeasuredRightlyOrRefused) {
  PhotoScene scene = TelephoneScene();
  PhotoOptions options;
  GetParam().spoil(scene, options);
  RgbImage image = RenderPhoto(scene, {{&Shirt().mesh, Shirt().x}});
  GetParam().edit(image);
  const std::string path = testing::TempDir() + "/kind_" + GetParam().name + ".jpg";
  scene.width = image.width;
  scene.height = image.height;
  WritePhotoFile(scene, image, path);
  const PhotoResult result = MeasurePhoto(ReadPhotograph(path), options);
  EXPECT_STREQ(ToString(result.fault), ToString(GetParam().fault)) << result.reason;
  EXPECT_GT(result.overlay.width, 0);
  if (result.fault == PhotoFault::kNone) {
    EXPECT_NEAR(100 * result.shape.drape_coefficient, 100 * Shirt().coefficient, 0.5);
  } else {
    EXPECT_FALSE(result.reason.empty());
    EXPECT_EQ(result.reason.find('\n'), std::string::npos);
  }
}

using Options = PhotoOptions;
constexpr PhotoFault kGood = PhotoFault::kNone;

INSTANTIATE_TEST_SUITE_P(
    All, PhotoKinds,
    testing::Values(
        Kind{"upside_down", kGood, [](PhotoScene& s, Options&) { s.orientation = 3; }},
        Kind{"on_its_side", kGood, [](PhotoScene& s, Options&) { s.orientation = 6; }},
        Kind{"striped_cloth", kGood,
             [](PhotoScene& s, Options&) {
               s.cloth = {0.15, 0.18, 0.4};
               s.stripe = {0.5, 0.2, 0.2};
               s.stripes = 0.02;
               s.disc = {0.9, 0.9, 0.88};
             }},
        Kind{"stripes_like_the_ground", PhotoFault::kNotADrape,
             [](PhotoScene& s, Options&) {
               s.stripe = s.ground;
               s.stripes = 0.025;
               s.disc = {0.15, 0.15, 0.15};
             }},
        Kind{"dark_on_dark", PhotoFault::kNoDisc,
             [](PhotoScene& s, Options&) {
               s.cloth = {0.16, 0.16, 0.17};
               s.ground = {0.14, 0.14, 0.14};
             }},
        Kind{"hand_on_the_hem", PhotoFault::kCroppedCloth,
             [](PhotoScene& s, Options&) {
               s.patches.push_back(Rectangle({0.82, 0.62, 0.52}, 0.1, 0.9, -0.05, 0.03, 0.01));
             }},
        Kind{"finger_on_the_disc", kGood,
             [](PhotoScene& s, Options&) {
               s.patches.push_back(Rectangle({0.82, 0.62, 0.52}, -0.11, -0.05, -0.01, 0.01, 0.01));
             }},
        Kind{"ruler_beside", kGood,
             [](PhotoScene& s, Options&) {
               s.patches.push_back(Rectangle({0.9, 0.8, 0.3}, -0.25, 0.25, 0.22, 0.25, -0.2));
             }},
        Kind{"ruler_under_the_hem", kGood,
             [](PhotoScene& s, Options&) {
               s.patches.push_back(Rectangle({0.3, 0.25, 0.2}, -0.25, 0.25, 0.08, 0.12, -0.2));
             }},
        Kind{"hard_shadow", kGood,
             [](PhotoScene& s, Options&) {
               s.shadow = 0.6;
               s.soft = 0.003;
               s.light = {0.45, 0.3};
             }},
        Kind{"hard_shadow_on_dark_cloth", kGood,
             [](PhotoScene& s, Options&) {
               s.cloth = {0.1, 0.1, 0.11};
               s.shadow = 0.7;
               s.soft = 0.003;
               s.light = {0.45, 0.3};
             }},
        Kind{"moved_a_little", kGood, [](PhotoScene& s, Options&) { s.motion = 5; }},
        Kind{"moved_much", PhotoFault::kTwoSpecimens,
             [](PhotoScene& s, Options&) { s.motion = 31; }},
        Kind{"grey", kGood, [](PhotoScene&, Options&) {},
             [](RgbImage& image) {
               const std::vector<uint8_t> grey = GreyLevels(image);
               for (size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = grey[i / 3];
             }},
        Kind{"screenshot_with_bars", PhotoFault::kCroppedCloth,
             [](PhotoScene& s, Options& o) {
               s.has_exif = false;
               o.focal_35mm = 32;
             },
             [](RgbImage& image) {
               Fill(&image, 0, 90, 0);
               Fill(&image, image.height - 90, image.height, 0);
             }},
        Kind{"wooden_table", kGood,
             [](PhotoScene& s, Options&) {
               s.ground = {0.75, 0.66, 0.52};
               for (int i = -12; i < 12; i += 2)
                 s.patches.push_back(
                     Rectangle({0.68, 0.58, 0.45}, -1.0, 1.0, 0.08 * i, 0.08 * i + 0.08, -0.249));
             }},
        Kind{"tiles", PhotoFault::kUnevenGround,
             [](PhotoScene& s, Options&) {
               for (int i = -12; i < 12; ++i)
                 for (int k = -12; k < 12; ++k)
                   if ((i + k) % 2 == 0)
                     s.patches.push_back(Rectangle({0.25, 0.25, 0.28}, 0.08 * i, 0.08 * i + 0.08,
                                                   0.08 * k, 0.08 * k + 0.08, -0.249));
             }},
        Kind{"disc_beside_the_support", PhotoFault::kWrongSize,
             [](PhotoScene& s, Options&) {
               s.disc_place = {0.012, 0.0};
             }},
        Kind{"vignette_and_yellow_light", kGood, [](PhotoScene& s, Options&) { s.falloff = 0.5; },
             [](RgbImage& image) {
               for (size_t i = 2; i < image.rgb.size(); i += 3)
                 image.rgb[i] = static_cast<uint8_t>(0.7 * image.rgb[i]);
             }}),
    [](const testing::TestParamInfo<Kind>& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace drape
