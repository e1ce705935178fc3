// SPDX-License-Identifier: Apache-2.0
#include "losses/image/segmentation.h"

#include <gmock/gmock.h>

#include <functional>

#include "losses/metrics/metrics.h"
#include "physics/util/errors.h"
#include "tests/losses/image/photograph.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

const GrayImage& Star() {
  static const GrayImage star = StarSilhouette(Camera());
  return star;
}

void ExpectRefused(const GrayImage& image, const std::string& text) {
  EXPECT_THAT([&] { SegmentSilhouette(image, "a.png"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("a.png: "), HasSubstr(text))));
}

TEST(Segmentation, LeavesASilhouetteAsItIs) {
  GrayImage star = Star();
  for (float& c : star.coverage) c = 0.01f + 0.98f * c;  // as JPEG leaves it
  const Silhouette silhouette = SegmentSilhouette(star, "a.png");
  EXPECT_EQ(silhouette.image.coverage, star.coverage);
  EXPECT_THAT(silhouette.segmentation.Notes(), IsEmpty());
}

// Half grey would take the background of the dim ones for cloth.
TEST(Segmentation, FindsTheClothInPhotographs) {
  const Camera camera = PhotographCamera();
  const GrayImage star = StarSilhouette(camera);
  for (const Light& light : {Light{}, Light{.cloth = 0.12, .background = 0.48},
                             Light{.cloth = 0.05, .background = 0.9, .falloff = 0.4},
                             Light{.cloth = 0.6, .background = 0.95, .falloff = 0.1}}) {
    const Silhouette found = SegmentSilhouette(Photograph(star, light), "photo");
    EXPECT_TRUE(found.segmentation.photograph);
    EXPECT_GT(IntersectionOverUnion(found.image, star), 0.99) << light.background;
    EXPECT_NEAR(CoverageArea(found.image, camera) / CoverageArea(star, camera), 1, 0.005);
    EXPECT_THAT(found.segmentation.Notes()[0], HasSubstr("photograph: grey levels of "));
  }
}

TEST(Segmentation, CutsWhatIsNotTheCloth) {
  GrayImage image = Star();
  FillRectangle(&image, 0, 0, 12, 200, 1.0f);    // a ruler at the border
  FillRectangle(&image, 230, 230, 10, 8, 1.0f);  // a label
  image.at(20, 240) = 1.0f;                      // dust
  const Silhouette found = SegmentSilhouette(image, "a.png");
  EXPECT_EQ(found.image.coverage, Star().coverage);
  EXPECT_THAT(found.segmentation.Notes(),
              ElementsAre("cut 3 parts outside the cloth: 2400 px at (6, 100), 80 px at "
                          "(234, 234), 1 px at (20, 240)"));
}

TEST(Segmentation, FillsSmallHoles) {
  GrayImage image = Star();
  FillRectangle(&image, 120, 120, 10, 10, 0.0f);
  const Silhouette found = SegmentSilhouette(image, "a.png");
  EXPECT_EQ(found.image.coverage, Star().coverage);
  EXPECT_THAT(found.segmentation.Notes(),
              ElementsAre("filled 1 hole in the cloth: 100 px at (124, 124)"));
}

TEST(Segmentation, TakesMasksThatAreWhiteOnBlack) {
  GrayImage image = Star();
  for (float& c : image.coverage) c = 1 - c;
  const Silhouette found = SegmentSilhouette(image, "a.png");
  EXPECT_GT(IntersectionOverUnion(found.image, Star()), 0.9999);
  EXPECT_THAT(found.segmentation.Notes(),
              ElementsAre("the picture is white on black and was inverted"));
}

TEST(Segmentation, FillsTheSupportOfAPaperRing) {
  const Camera camera;
  GrayImage ring = Star();
  for (int row = 0; row < ring.height; ++row)
    for (int col = 0; col < ring.width; ++col)
      if (std::hypot(col - camera.cx, row - camera.cy) < 0.09 * camera.scale)
        ring.at(col, row) = 0.0f;
  const Silhouette found = SegmentSilhouette(ring, "a.png");
  EXPECT_EQ(found.image.coverage, Star().coverage);
  EXPECT_THAT(found.segmentation.Notes(),
              ElementsAre("the round hole in the middle of the cloth was filled: the support"));
}

// A line around a place is no cloth with a support in its middle.
TEST(Segmentation, RefusesARingInWhichNoClothHangs) {
  GrayImage ring(256, 256);
  for (int row = 0; row < ring.height; ++row)
    for (int col = 0; col < ring.width; ++col) {
      const double r = std::hypot(col - 127.5, row - 127.5);
      if (r < 85 && r > 83) ring.at(col, row) = 1.0f;
    }
  EXPECT_INPUT_ERROR(SegmentSilhouette(ring, "a.png"), "holes in the cloth");
}

Camera SmallCamera() {
  Camera camera;
  camera.width = 480;
  camera.height = 400;
  camera.scale = 1200;
  camera.cx = 245;
  camera.cy = 203;
  return camera;
}

// Grey levels by the distance from the support's centre and from the cloth's edge [px].
GrayImage PaintStar(const Camera& camera, const std::function<double(double, double)>& grey) {
  GrayImage image(camera.width, camera.height);
  for (int row = 0; row < camera.height; ++row)
    for (int col = 0; col < camera.width; ++col) {
      const double x = col - camera.cx, y = camera.cy - row, r = std::hypot(x, y);
      const double outside = r - camera.scale * StarRadius(std::atan2(y, x));
      image.at(col, row) = static_cast<float>(1 - grey(r / camera.scale, outside));
    }
  return image;
}

// An opaque disc under translucent cloth on a light table, with and without a dark frame: the cloth
// ends at its own edge, not at that of the disc.
TEST(Segmentation, FindsTranslucentClothOnALightTable) {
  const Camera camera = SmallCamera();
  const double area = CoverageArea(StarSilhouette(camera), camera);
  for (const double cloth : {0.35, 0.75, 0.85}) {
    const GrayImage open = PaintStar(camera, [&](double r, double outside) {
      return r < 0.09 ? 0.1 : outside < 0 ? cloth : 0.99;
    });
    GrayImage framed = open;
    FillRectangle(&framed, 0, 0, 480, 15, 0.97f);
    FillRectangle(&framed, 0, 385, 480, 15, 0.97f);
    FillRectangle(&framed, 0, 0, 40, 400, 0.97f);
    FillRectangle(&framed, 450, 0, 30, 400, 0.97f);
    for (const GrayImage& image : {open, framed}) {
      const Silhouette found = SegmentSilhouette(image, "table");
      EXPECT_NEAR(CoverageArea(found.image, camera) / area, 1, 0.01) << cloth;
    }
  }
}

// The shadow of a lamp on one side is as dark as the translucent cloth above, and is none.
TEST(Segmentation, LeavesAShadowOut) {
  const Camera camera = SmallCamera();
  Camera shifted = camera;
  shifted.cx += 28;
  shifted.cy -= 20;
  const GrayImage star = StarSilhouette(camera), shadow = StarSilhouette(shifted);
  GrayImage image(camera.width, camera.height);
  for (size_t i = 0; i < image.coverage.size(); ++i)
    image.coverage[i] = star.coverage[i] > 0.5f ? 0.8f : 0.1f + 0.35f * shadow.coverage[i];
  const Silhouette found = SegmentSilhouette(image, "lamp");
  EXPECT_GT(IntersectionOverUnion(found.image, star), 0.99);
  EXPECT_THAT(found.segmentation.Notes(), Contains("a shadow beside the cloth is left out"));
}

void ExpectArea(const GrayImage& image, const Camera& camera) {
  const Silhouette found = SegmentSilhouette(image, "photo");
  EXPECT_NEAR(CoverageArea(found.image, camera) / CoverageArea(StarSilhouette(camera), camera), 1,
              0.01);
}

// The picture is dark but for a cloth that is a hundredth of it.
TEST(Segmentation, FindsASmallClothOnABlackGround) {
  Camera camera = PhotographCamera();
  camera.scale = 420;
  ExpectArea(PaintStar(camera, [](double, double outside) { return outside < 0 ? 0.6 : 0.05; }),
             camera);
}

// The light stripes are farther from the mean of all stripes than the ground is.
TEST(Segmentation, FindsAPrint) {
  const Camera camera = SmallCamera();
  GrayImage image = PaintStar(camera, [](double, double outside) { return outside < 0 ? 0 : 0.5; });
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      if (image.at(col, row) == 1.0f) image.at(col, row) = row / 6 % 2 == 0 ? 0.95f : 0.25f;
  ExpectArea(image, camera);
}

// The lines are lighter than the cloth, which is lighter than what is between them.
TEST(Segmentation, FindsClothOnARuledGround) {
  const Camera camera = SmallCamera();
  const GrayImage star = StarSilhouette(camera);
  GrayImage image(camera.width, camera.height);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      image.at(col, row) = star.at(col, row) > 0.5f       ? 0.4f
                           : col % 20 < 2 || row % 20 < 2 ? 0.1f
                                                          : 0.8f;
  ExpectArea(image, camera);
}

// A shade of the cloth from the disc to the hem on one side, with an edge of its own, is of the
// cloth: no other threshold finds the same.
TEST(Segmentation, TakesNoShadeOfTheClothForACloth) {
  const Camera camera = SmallCamera();
  GrayImage image = PaintStar(camera, [](double r, double outside) {
    return r < 0.09 ? 0.1 : outside < 0 ? 0.85 : 0.99;
  });
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      if (std::abs(row - camera.cy) < 0.7 * (col - camera.cx) && image.at(col, row) > 0.1f &&
          image.at(col, row) < 0.2f)
        image.at(col, row) = 0.225f;
  ExpectArea(image, camera);
}

// A light table that the picture cuts off at all four corners.
TEST(Segmentation, FindsClothOnATableThatIsCutOff) {
  const Camera camera = SmallCamera();
  GrayImage image = PaintStar(camera, [](double r, double outside) {
    return r < 0.09 ? 0.1 : outside < 0 ? 0.75 : 0.99;
  });
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      if (std::abs(col - 245) + std::abs(row - 203) > 290) image.at(col, row) = 0.97f;
  ExpectArea(image, camera);
}

// A highlight hides the edge of the cloth, not what is farther inside.
TEST(Segmentation, RefusesGlareAtTheEdgeAlone) {
  const Camera camera = SmallCamera();
  const auto with_glare = [&](double place) {
    GrayImage image =
        PaintStar(camera, [](double, double outside) { return outside < 0 ? 0.4 : 0.1; });
    for (int row = 0; row < image.height; ++row)
      for (int col = 0; col < image.width; ++col)
        if (std::hypot(col - camera.cx - place * camera.scale, row - camera.cy) < 14)
          image.at(col, row) = 0.0f;
    return image;
  };
  ExpectArea(with_glare(0.06), camera);
  ExpectRefused(with_glare(StarRadius(0)), "glare");
}

// White cloth, of which a flank in shade is as grey as the ground in its shadow.
TEST(Segmentation, NotesThatAShadeMayPassForAShadow) {
  const GrayImage image = PaintStar(SmallCamera(), [](double, double outside) {
    return outside < 0 ? 0.9 : 0.5 - 0.15 * std::exp(-outside / 20);
  });
  const Silhouette found = SegmentSilhouette(image, "photo");
  EXPECT_THAT(found.segmentation.Notes(), Contains(HasSubstr("in shade may pass for a shadow")));
}

TEST(Segmentation, RefusesWhatIsNoPieceOfCloth) {
  GrayImage hole = Star(), twins(256, 256), border = Star(), noise(256, 256), speckled = Star();
  FillRectangle(&hole, 90, 90, 75, 75, 0.0f);
  ExpectRefused(hole, "holes in the cloth: 5625 px at (127, 127)");
  FillRectangle(&twins, 20, 80, 60, 90, 1.0f);
  FillRectangle(&twins, 180, 90, 55, 90, 1.0f);
  ExpectRefused(twins, "two dark parts of similar size");
  FillRectangle(&border, 0, 100, 128, 40, 1.0f);
  ExpectRefused(border, "cloth touches the border at the left");
  std::mt19937 random(3);
  for (float& c : noise.coverage) c = random() % 2 == 0 ? 1.0f : 0.0f;
  ExpectRefused(noise, "a.png");
  for (float& c : speckled.coverage) c = random() % 20 == 0 ? 1.0f : c;
  ExpectRefused(speckled, "is noise: ");
  ExpectRefused(GrayImage(15, 40), "at least 16x16");
  ExpectRefused(GrayImage(40, 400), "too small: the picture is 40x400 px, expected at least 64");
  ExpectRefused(GrayImage(400, 400), "no cloth: the picture is of one colour");
  ExpectRefused(GrayImage(400, 400, 1.0f), "too dark");
  GrayImage odd = Star();
  odd.at(3, 3) = std::nanf("");
  ExpectRefused(odd, "not in [0, 1]");
}

}  // namespace
}  // namespace drape
