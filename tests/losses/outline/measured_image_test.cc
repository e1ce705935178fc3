// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/measured_image.h"

#include <gmock/gmock.h>

#include "physics/util/errors.h"
#include "tests/losses/image/photograph.h"

namespace drape {
namespace {

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

}  // namespace
}  // namespace drape
