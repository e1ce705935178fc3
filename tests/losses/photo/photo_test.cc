// SPDX-License-Identifier: Apache-2.0
#include "losses/photo/photo.h"

#include <gmock/gmock.h>

#include <functional>

#include "physics/util/errors.h"
#include "tests/losses/photo/rendered/photo_trial.h"

namespace drape {
namespace {

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
    EXPECT_THAT(trial->result.warnings, testing::IsEmpty());
    EXPECT_GT(100 * trial->result.coefficient_sd, 0.2);
    EXPECT_LT(100 * trial->result.coefficient_sd, 0.7);
    EXPECT_LT(std::abs(trial->error_of_estimate), 300 * trial->result.coefficient_sd);
  }
  EXPECT_GT(blurred.result.coefficient_sd, 1.2 * sharp.result.coefficient_sd);
}

// What is good enough to be measured but may be off is said.
TEST(Photo, NotesWhatMayBeOff) {
  const auto expect = [](const PhotoScene& scene, const char* note) {
    const PhotoTrial trial = Try(scene);
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
       {{-0.1, -0.06, 0.01}, {-0.03, -0.06, 0.01}, {-0.03, 0.06, 0.01}, {-0.1, 0.06, 0.01}}});
  expect(covered, "the disc's rim is seen on ");
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
                    BadPhoto{"cloth_like_ground", PhotoFault::kNoDisc,
                             [](PhotoScene& s, Options&, Pieces&) {
                               s.cloth = s.ground * 0.97;
                               s.disc = {0.2, 0.2, 0.2};
                               s.shadow = 0;
                             }},
                    BadPhoto{"out_of_focus", PhotoFault::kBlur,
                             [](PhotoScene& s, Options&, Pieces&) { s.blur = 5; }},
                    BadPhoto{"shaken", PhotoFault::kBlur,
                             [](PhotoScene& s, Options&, Pieces&) { s.motion = 25; }},
                    BadPhoto{"far_away", PhotoFault::kTooSmall,
                             [](PhotoScene& s, Options&, Pieces&) { s.eye.z() = 3; }},
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
}

}  // namespace
}  // namespace drape
