// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/measured_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "losses/silhouette/silhouette.h"
#include "physics/util/errors.h"
#include "tests/losses/disc.h"
#include "tests/losses/image/photograph.h"

namespace drape {
namespace {

using std::numbers::pi;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

MeasuredImage Measure(const GrayImage& image, const CameraInput& input = {},
                      CentreMode centre = CentreMode::kOutline) {
  return MeasureImage(SegmentSilhouette(image, "a.png"), input, centre, {}, "a.png");
}

void ExpectRefused(const GrayImage& image, const CameraInput& input, const std::string& text) {
  EXPECT_THAT([&] { Measure(image, input); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("a.png: "), HasSubstr(text))));
}

// DC of the star, ∫r²/2 in closed form.
const double kStarDc = (0.120 * 0.120 + 0.5 * (0.012 * 0.012 + 0.006 * 0.006) - 0.09 * 0.09) /
                       (0.15 * 0.15 - 0.09 * 0.09);

TEST(MeasureImage, FindsTheCentreOfALargeImage) {
  Camera actual = PhotographCamera();
  actual.cx = 850;  // the image's centre is not under the support
  actual.cy = 450;
  for (const CameraInput& input :
       {CameraInput{.scale = 2500, .file = {}}, CameraInput{.image_width_mm = 480, .file = {}}}) {
    const MeasuredImage measured = Measure(StarSilhouette(actual), input);
    EXPECT_NEAR(measured.camera.cx, actual.cx, 0.05);
    EXPECT_NEAR(measured.camera.cy, actual.cy, 0.05);
    EXPECT_DOUBLE_EQ(measured.camera.scale, 2500);
    EXPECT_NEAR(measured.quality.drape_coefficient, kStarDc, 1e-3);
    EXPECT_EQ(measured.quality.overhanging, 0);
    EXPECT_TRUE(measured.quality.scale_given);
    EXPECT_NEAR(measured.quality.centre_offset, 850 - 599.5, 1);
    EXPECT_THAT(CameraText(measured.camera, measured.quality),
                HasSubstr("1200x900 px, 2500.0 px/m (given), centre (850.0, 450.0) found from"));
  }
}

TEST(MeasureImage, NeverGuessesAScale) {
  const GrayImage photo = StarSilhouette(PhotographCamera());
  ExpectRefused(photo, {},
                "image is 1200x900 px and its scale is not given, expected "
                "image_width_mm");
  EXPECT_THROW(Measure(photo, {.scale = 2500, .image_width_mm = 480, .file = {}}), InputError);
  ExpectRefused(photo, {.width = 600, .scale = 2500, .file = {}}, "expected 600x900");
  ExpectRefused(photo, {.kind = CameraKind::kPinhole, .scale = 2500, .file = {}},
                "expected 256x256");
  EXPECT_THAT(Measure(StarSilhouette(Camera())).quality.notes, IsEmpty());
}

TEST(MeasureImage, RefusesWhatNoDrapeShows) {
  const GrayImage star = StarSilhouette(Camera());
  ExpectRefused(star, {.scale = 500, .file = {}}, "the outline reaches 1");
  ExpectRefused(star, {.scale = 500, .file = {}}, "is the scale of 500.0 px/m (given) right?");
  ExpectRefused(star, {.scale = 960, .file = {}}, "comes to 7");
  GrayImage spiral(256, 256);
  for (int row = 0; row < 256; ++row) {
    for (int col = 0; col < 256; ++col) {
      const double x = col - 127.5, y = 127.5 - row, r = std::hypot(x, y);
      const double turns = std::atan2(y, x) / (2 * M_PI) + r / 25;
      spiral.at(col, row) = r < 105 && (turns - std::floor(turns) < 0.6 || r < 20);
    }
  }
  ExpectRefused(spiral, {}, "of the rays from the centre cross the outline more than once");
  GrayImage disc(256, 256);
  for (int row = 0; row < 256; ++row)
    for (int col = 0; col < 256; ++col)
      disc.at(col, row) = std::hypot(col - 127.5, row - 127.5) < 0.155 * 719.5;
  ExpectRefused(disc, {}, "the drape coefficient is 1.1");
}

TEST(MeasureImage, NotesWhatIsSlightlyOff) {
  const GrayImage star = StarSilhouette(Camera());
  const MeasuredImage large = Measure(star, {.scale = 640, .file = {}});
  ASSERT_EQ(large.quality.notes.size(), 1u);
  EXPECT_THAT(large.quality.notes[0], HasSubstr("more than the cloth's 150 mm"));
  const MeasuredImage moved = Measure(star, {.cx = 120, .file = {}}, CentreMode::kNominal);
  EXPECT_EQ(moved.camera.cx, 120);
  ASSERT_EQ(moved.quality.notes.size(), 1u);
  EXPECT_THAT(moved.quality.notes[0], HasSubstr("7.5 px from the centre used"));
}

// A hem cannot stretch: folds of a specimen of 24 cm are no drape of 30 cm.
TEST(MeasureImage, NamesTheSizeThatFits) {
  const DrapeDiscs small{0.12, 0.09}, usual;
  // Eight folds whose hem, at its heights, is as long as the edge of the flat cloth.
  const auto folded = [](double amplitude) {
    Eigen::VectorXd r(360);
    for (int k = 0; k < 360; ++k) r[k] = 0.108 + amplitude * std::cos(8 * k * pi / 180);
    return [r](const DrapeDiscs&) { return r; };
  };
  double amplitude = 0.0;
  while (MeasureHem(folded(amplitude), small).relative < 1) amplitude += 1e-4;
  EXPECT_LT(amplitude, 0.011);
  EXPECT_EQ(MeasureHem(folded(amplitude), small).usual, 0);
  const HemLength wrong = MeasureHem(folded(amplitude), usual);
  EXPECT_DOUBLE_EQ(wrong.usual, 0.24);
  EXPECT_THAT(SizeText(wrong, usual), AllOf(HasSubstr("this looks like a specimen of 24 cm"),
                                            HasSubstr("expected specimen = 0.24")));
  EXPECT_EQ(MeasureHem(folded(0), usual).usual, 0);  // no size fits
}

TEST(MeasureImage, SendsPhotographsToDrapePhoto) {
  Light light;
  const GrayImage photo = Photograph(StarSilhouette(PhotographCamera()), light);
  ExpectRefused(photo, {}, "is a photograph without a scale: drape_photo");
  Silhouette silhouette = SegmentSilhouette(photo, "a.png");
  silhouette.segmentation.focal_35mm = 26;
  const MeasuredImage measured = MeasureImage(std::move(silhouette), {.scale = 2500, .file = {}},
                                              CentreMode::kOutline, {}, "a.png");
  EXPECT_TRUE(measured.quality.doubtful);
  EXPECT_THAT(measured.quality.notes, testing::Contains(HasSubstr("drape_photo measures such")));
}

constexpr int kTurns = 360;
constexpr double kTurn = 2 * pi * 25 / kTurns;

// Folds of one order on a weaker wave that distinguishes left from right.
Eigen::VectorXd Folded(int folds, double phase) {
  Eigen::VectorXd r(kTurns);
  for (int i = 0; i < kTurns; ++i) {
    const double t = 2 * pi * i / kTurns - phase;
    r[i] = .11 + .01 * std::cos(folds * t) + .004 * std::sin(2 * t);
  }
  return r;
}

Eigen::VectorXd Mirror(const Eigen::VectorXd& r) {
  Eigen::VectorXd result = r;
  for (Eigen::Index i = 1; i < r.size(); ++i) result[i] = r[r.size() - i];
  return result;
}

TEST(MatchOutlines, FindsTheSameOutline) {
  const Eigen::VectorXd r = Folded(5, 1);
  for (const auto freedom :
       {OutlineFreedom::kFixed, OutlineFreedom::kRotation, OutlineFreedom::kRotationAndMirror}) {
    const OutlineMatch match = MatchOutlines(r, r, freedom);
    EXPECT_EQ(match.rms, 0.0);
    EXPECT_EQ(match.rotation, 0.0);
    EXPECT_FALSE(match.mirrored);
  }
}

TEST(MatchOutlines, FindsTheRotationOfB) {
  const Eigen::VectorXd a = Folded(5, 1 + kTurn), b = Folded(5, 1);
  EXPECT_GT(MatchOutlines(a, b).rms, 5e-3);
  const OutlineMatch match = MatchOutlines(a, b, OutlineFreedom::kRotation);
  EXPECT_LT(match.rms, 1e-14);
  EXPECT_NEAR(match.rotation, kTurn, 1e-12);
}

TEST(MatchOutlines, FindsTheMirrorImageOnlyWhenAsked) {
  const Eigen::VectorXd a = Folded(5, 1), b = Mirror(Folded(5, 1 - kTurn));
  EXPECT_GT(MatchOutlines(a, b, OutlineFreedom::kRotation).rms, 1e-3);
  const OutlineMatch match = MatchOutlines(a, b, OutlineFreedom::kRotationAndMirror);
  EXPECT_LT(match.rms, 1e-14);
  EXPECT_TRUE(match.mirrored);
  EXPECT_NEAR(match.rotation, kTurn, 1e-12);
}

TEST(RefineRotation, FindsARotationBetweenTheAngles) {
  for (const double part : {-0.4, 0.0, 0.3}) {
    for (const bool mirrored : {false, true}) {
      const double turn = kTurn + part * 2 * pi / kTurns;
      const Eigen::VectorXd a = Folded(5, 1 + turn);
      const Eigen::VectorXd b = mirrored ? Mirror(Folded(5, 1)) : Folded(5, 1);
      const OutlineMatch match = MatchOutlines(a, b, OutlineFreedom::kRotationAndMirror);
      EXPECT_NEAR(match.rotation, kTurn, 1e-12);
      const OutlineMatch refined = RefineRotation(a, b, match);
      EXPECT_NEAR(refined.rotation, turn, 1e-5);
      EXPECT_EQ(refined.mirrored, mirrored);
    }
  }
}

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
