// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/photo.h"

#include <gmock/gmock.h>

#include <functional>

#include "physics/util/errors.h"
#include "tests/losses/photo/rendered/photo_file.h"
#include "tests/losses/photo/rendered/photo_trial.h"

namespace drape {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = M_PI / 180;

PhotoOptions With(PhotoMarker marker, double tag = 0.0, double px_per_m = 0.0) {
  PhotoOptions options;
  options.marker = marker;
  options.tag = tag;
  options.px_per_m = px_per_m;
  return options;
}

PhotoTrial Try(const PhotoScene& scene, const PhotoOptions& options = {}) {
  return TryPhoto(scene, Wool(), options, testing::TempDir());
}

TEST(Photo, OfATiltedTelephoneGivesTheDrapeCoefficient) {
  PhotoScene scene = SmallScene();
  scene.tilt = {6 * kDegree, -4 * kDegree};
  scene.eye = {-0.07, -0.1, 1.0};
  scene.orientation = 8;
  const PhotoTrial trial = Try(scene);
  ASSERT_EQ(trial.result.fault, PhotoFault::kNone) << trial.result.reason;
  EXPECT_NEAR(trial.error_of_estimate, 0, 0.7);
  EXPECT_LT(trial.error_of_plane, -5);
  EXPECT_LT(trial.outline_rms, 1.5);
  EXPECT_NEAR(trial.tilt_error, 0, 1.5 * kDegree);
  EXPECT_NEAR(trial.height_error, 0, 0.01);
}

TEST(Photo, OfATagNeedsNoDisc) {
  PhotoScene scene = SmallScene();
  scene.has_disc = false;
  scene.tag_side = 0.1;
  scene.tilt = {0.05, 0.03};
  scene.eye = {0.03, -0.05, 1.0};
  const PhotoTrial trial = Try(scene, With(PhotoMarker::kTag, 0.1));
  ASSERT_EQ(trial.result.fault, PhotoFault::kNone) << trial.result.reason;
  EXPECT_NEAR(trial.error_of_estimate, 0, 0.8);
  EXPECT_LT(trial.outline_rms, 3);
}

TEST(Photo, OfParallelLightNeedsTheScaleOnly) {
  PhotoScene scene = SmallScene();
  scene.focal_35mm = 38 * 50;
  scene.eye = {0, 0, 50};
  scene.has_exif = false;
  const double px_per_m = 38 * std::hypot(1000, 750) / 43.2666;
  const PhotoTrial trial = Try(scene, With(PhotoMarker::kNone, 0, px_per_m));
  ASSERT_EQ(trial.result.fault, PhotoFault::kNone) << trial.result.reason;
  EXPECT_EQ(trial.result.camera.kind, CameraKind::kOrthographic);
  EXPECT_NEAR(trial.error_of_estimate, 0, 0.7);
}

// Shades of its folds are all that tells a cloth from a ground of its colour.
TEST(Photo, OfAClothLikeItsGroundShowsShades) {
  PhotoScene scene = SmallScene();
  scene.cloth = scene.ground * 0.97;
  scene.disc = {0.2, 0.2, 0.2};
  scene.shadow = 0;
  const PhotoTrial trial = Try(scene);
  ASSERT_EQ(trial.result.fault, PhotoFault::kNone) << trial.result.reason;
  EXPECT_NEAR(trial.error_of_estimate, 0, 0.7);
}

// A forgotten diameter: the outline is no drape of a specimen of 30 cm.
TEST(Photo, NamesTheSizeThatFits) {
  PhotoOptions options;
  options.specimen = 0.36;
  const PhotoTrial trial = Try(SmallScene(), options);
  EXPECT_EQ(trial.result.fault, PhotoFault::kWrongSize);
  EXPECT_THAT(trial.result.reason, testing::HasSubstr("looks like a specimen of 30 cm"));
}

// Of the softest cloth a strip is seen beside the disc that is narrower than the blur: the light of
// disc, cloth and ground adds up in its pixels.
TEST(Photo, OfASoftClothHasAStripBesideTheDisc) {
  const KnownDrape knit = SimulateDrapeOfSix(0);
  PhotoScene scene;
  scene.blur = 1.2;
  const PhotoTrial trial = TryPhoto(scene, knit, {}, testing::TempDir());
  ASSERT_EQ(trial.result.fault, PhotoFault::kNone) << trial.result.reason;
  EXPECT_NEAR(trial.error_by_outline, 0, 0.2);
}

// The standard deviation is of the size of the errors, and larger of a picture that tells less.
TEST(Photo, SaysHowWellTheCoefficientIsKnown) {
  PhotoScene scene = SmallScene();
  const PhotoTrial sharp = Try(scene);
  scene.blur = 2;
  const PhotoTrial blurred = Try(scene);
  for (const PhotoTrial* trial : {&sharp, &blurred}) {
    ASSERT_EQ(trial->result.fault, PhotoFault::kNone) << trial->result.reason;
    EXPECT_THAT(trial->result.warnings, testing::Each(testing::HasSubstr("shadow")));
    EXPECT_GT(100 * trial->result.coefficient_sd, 0.2);
    EXPECT_LT(100 * trial->result.coefficient_sd, 0.7);
    EXPECT_LT(std::abs(trial->error_of_estimate), 300 * trial->result.coefficient_sd);
  }
  EXPECT_GT(blurred.result.coefficient_sd, 1.2 * sharp.result.coefficient_sd);
}

// What is good enough to be measured but may be off is said.
TEST(Photo, NotesWhatMayBeOff) {
  const auto expect = [](const PhotoScene& scene, const char* note,
                         const PhotoOptions& options = {}) {
    const PhotoTrial trial = Try(scene, options);
    ASSERT_EQ(trial.result.fault, PhotoFault::kNone) << trial.result.reason;
    EXPECT_THAT(trial.result.warnings, testing::Contains(testing::HasSubstr(note)));
  };
  PhotoScene tilted = SmallScene(), moved = SmallScene(), covered = SmallScene();
  tilted.tilt = {14 * kDegree, 0};
  tilted.eye = {0, -0.25, 1.0};
  expect(tilted, "the camera is tilted by 14 degrees");
  moved.disc_place = {0.008, 0};
  expect(moved, "off the centre of the disc");
  covered.patches.push_back(
      {{0.82, 0.62, 0.52},
       {{-0.1, -0.075, 0.01}, {-0.03, -0.075, 0.01}, {-0.03, 0.075, 0.01}, {-0.1, 0.075, 0.01}}});
  expect(covered, "the disc's rim is seen on ");
  PhotoScene far = SmallScene();
  far.focal_35mm *= 6;
  far.eye = {0, 0, 6.0};
  expect(far, "the camera seems to be 6.0 m above the support");
  PhotoOptions longer;
  longer.focal_35mm = 1.25 * SmallScene().focal_35mm;
  expect(SmallScene(), "mm was given and used", longer);
}

struct BadPhoto {
  const char* name;
  PhotoFault fault;
  std::function<void(PhotoScene&, PhotoOptions&, std::vector<ScenePiece>&)> spoil;
};

class BadPhotos : public testing::TestWithParam<BadPhoto> {};

TEST_P(BadPhotos, AreRefusedByName) {
  PhotoScene scene = SmallScene();
  PhotoOptions options;
  std::vector<ScenePiece> pieces = {{&Wool().mesh, Wool().x}};
  GetParam().spoil(scene, options, pieces);
  const RgbImage image = RenderPhoto(scene, pieces);
  const ExifData exif{.orientation = 1,
                      .focal_35mm = scene.has_exif ? scene.focal_35mm : 0.0,
                      .width = 1000,
                      .height = 750};
  const PhotoResult result = MeasurePhoto({image, exif}, options);
  EXPECT_STREQ(ToString(result.fault), ToString(GetParam().fault)) << result.reason;
  EXPECT_FALSE(result.reason.empty());
  EXPECT_EQ(result.reason.find('\n'), std::string::npos);
  EXPECT_GT(result.overlay.width, 0);
  EXPECT_EQ(result.silhouette.width, 0);
}

using Options = PhotoOptions;
using Pieces = std::vector<ScenePiece>;

INSTANTIATE_TEST_SUITE_P(
    Kinds, BadPhotos,
    testing::Values(BadPhoto{"no_disc", PhotoFault::kNoDisc,
                             [](PhotoScene& s, Options&, Pieces&) { s.has_disc = false; }},
                    BadPhoto{"no_tag", PhotoFault::kNoTag,
                             [](PhotoScene&, Options& o, Pieces&) {
                               o.marker = PhotoMarker::kTag;
                               o.tag = 0.1;
                             }},
                    BadPhoto{"cropped_at_the_side", PhotoFault::kCroppedCloth,
                             [](PhotoScene& s, Options&, Pieces&) { s.eye.x() = 0.4; }},
                    BadPhoto{"cropped_at_the_top", PhotoFault::kCroppedCloth,
                             [](PhotoScene& s, Options&, Pieces&) { s.eye.y() = -0.3; }},
                    BadPhoto{"two_specimens", PhotoFault::kTwoSpecimens,
                             [](PhotoScene& s, Options&, Pieces& p) {
                               p[0].place = {-0.18, 0};
                               p.push_back({&Wool().mesh, Wool().x, {0.18, 0}});
                               s.eye.x() = 0;
                             }},
                    BadPhoto{"no_focal_length", PhotoFault::kNoFocalLength,
                             [](PhotoScene& s, Options&, Pieces&) { s.has_exif = false; }},
                    BadPhoto{"empty", PhotoFault::kNoCloth,
                             [](PhotoScene& s, Options&, Pieces& p) {
                               p.clear();
                               s.falloff = 0;
                             }},
                    BadPhoto{"dark", PhotoFault::kDark,
                             [](PhotoScene& s, Options&, Pieces&) { s.exposure = 0.015; }},
                    BadPhoto{"out_of_focus", PhotoFault::kBlur,
                             [](PhotoScene& s, Options&, Pieces&) { s.blur = 5; }},
                    BadPhoto{"shaken", PhotoFault::kBlur,
                             [](PhotoScene& s, Options&, Pieces&) { s.motion = 25; }},
                    BadPhoto{"far_away", PhotoFault::kTooSmall,
                             [](PhotoScene& s, Options&, Pieces&) { s.eye.z() = 3; }},
                    BadPhoto{"from_a_mountain", PhotoFault::kWrongSize,
                             [](PhotoScene&, Options& o, Pieces&) { o.focal_35mm = 10000; }},
                    BadPhoto{"close", PhotoFault::kTooClose,
                             [](PhotoScene& s, Options&, Pieces&) {
                               s.eye.z() = 0.5;
                               s.focal_35mm = 20;
                             }},
                    BadPhoto{"tilted", PhotoFault::kTilted,
                             [](PhotoScene& s, Options&, Pieces&) {
                               s.tilt = {22 * kDegree, 0};
                               s.eye = {0, -0.4, 1.0};
                             }},
                    BadPhoto{"glare", PhotoFault::kGlare,
                             [](PhotoScene& s, Options&, Pieces&) { s.glare = 0.02; }},
                    BadPhoto{"specimen_of_another_size", PhotoFault::kWrongSize,
                             [](PhotoScene&, Options& o, Pieces&) { o.specimen = 0.24; }},
                    BadPhoto{"disc_of_another_size", PhotoFault::kWrongSize,
                             [](PhotoScene&, Options& o, Pieces&) { o.disc = 0.24; }},
                    BadPhoto{"cropped_file", PhotoFault::kCroppedPhoto,
                             [](PhotoScene& s, Options&, Pieces&) { s.height = 600; }},
                    BadPhoto{"large_glare", PhotoFault::kGlare,
                             [](PhotoScene& s, Options&, Pieces&) { s.glare = 0.035; }},
                    BadPhoto{"support_of_another_size", PhotoFault::kWrongSize,
                             [](PhotoScene&, Options& o, Pieces&) { o.support = 0.24; }}),
    [](const testing::TestParamInfo<BadPhoto>& info) { return std::string(info.param.name); });

TEST(Photo, RefusesContradictoryOptions) {
  const Photograph photo{RenderPhoto(SmallScene(), {}), {}};
  PhotoOptions large_support;
  large_support.support = 0.4;
  EXPECT_THROW(MeasurePhoto(photo, large_support), InputError);
  EXPECT_THROW(MeasurePhoto(photo, With(PhotoMarker::kTag)), InputError);
  EXPECT_THROW(MeasurePhoto(photo, With(PhotoMarker::kNone)), InputError);
  PhotoOptions masked = With(PhotoMarker::kNone, 0, 1000);
  masked.mask = testing::TempDir() + "/photo_mask.png";
  const auto expect_mask = [&](const GrayImage& mask, const char* message) {
    WritePng(mask, masked.mask);
    EXPECT_THAT([&] { MeasurePhoto(photo, masked); },
                testing::ThrowsMessage<InputError>(testing::HasSubstr(message)));
  };
  expect_mask({500, 375}, "mask is 500x375 px, expected the photograph's 1000x750");
  expect_mask({1000, 750}, "mask is of one colour");
  expect_mask({1000, 750, 1.0f}, "mask is of one colour");
}

// Pictures that show nothing are refused by name, before any work on them.
TEST(Photo, RefusesPicturesThatShowNothing) {
  const auto expect = [](int width, int height, uint8_t grey, PhotoFault fault) {
    const RgbImage image{width, height, std::vector<uint8_t>(size_t(3) * width * height, grey)};
    const PhotoResult result = MeasurePhoto({image, {}}, With(PhotoMarker::kNone, 0, 1000));
    EXPECT_STREQ(ToString(result.fault), ToString(fault)) << width << ", " << height;
    EXPECT_GT(result.overlay.width, 0);
  };
  expect(800, 800, 120, PhotoFault::kNoCloth);
  expect(800, 600, 255, PhotoFault::kNoCloth);
  expect(800, 600, 10, PhotoFault::kDark);
  for (const int side : {1, 2, 17, 63}) expect(side, 500, 120, PhotoFault::kTooSmall);
  expect(2000, 70, 120, PhotoFault::kTooSmall);
}

// Photographs as they come: none is measured wrongly without a word. Each kind has the fault that
// is expected of it, or is measured within half a point.

const KnownDrape& Shirt() {
  static const KnownDrape drape = SimulateDrape("synthetic_shirt", 2);
  return drape;
}

PhotoScene TelephoneScene() {
  PhotoScene scene;
  scene.width = 1000;
  scene.height = 750;
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
        Kind{"stripes_like_the_ground", PhotoFault::kLowContrast,
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
        Kind{"moved_much", PhotoFault::kWrongSize,
             [](PhotoScene& s, Options&) {
               s.width = 1200;  // of fewer pixels it is blurred
               s.height = 900;
               s.motion = 31;
             }},
        Kind{"grey", kGood, [](PhotoScene&, Options&) {},
             [](RgbImage& image) {
               const std::vector<uint8_t> grey = GreyLevels(image);
               for (size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = grey[i / 3];
             }},
        Kind{"screenshot_with_bars", kGood,
             [](PhotoScene& s, Options& o) {
               s.has_exif = false;
               o.focal_35mm = 32;
             },
             [](RgbImage& image) {
               Fill(&image, 0, 75, 0);
               Fill(&image, image.height - 75, image.height, 0);
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
