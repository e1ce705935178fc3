// SPDX-License-Identifier: Apache-2.0
#include "losses/image/segmentation.h"

#include <gmock/gmock.h>

#include "losses/metrics/metrics.h"
#include "physics/util/errors.h"
#include "tests/losses/image/photograph.h"

namespace drape {
namespace {

using testing::AllOf;
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
    EXPECT_TRUE(found.segmentation.rescaled);
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

TEST(Segmentation, RefusesWhatIsNoPieceOfCloth) {
  GrayImage hole = Star(), twins(256, 256), border = Star(), noise(256, 256), speckled = Star();
  FillRectangle(&hole, 90, 90, 75, 75, 0.0f);
  ExpectRefused(hole, "holes in the cloth: 5625 px at (127, 127)");
  FillRectangle(&twins, 20, 80, 60, 90, 1.0f);
  FillRectangle(&twins, 180, 90, 55, 90, 1.0f);
  ExpectRefused(twins, "two dark parts of similar size");
  FillRectangle(&border, 0, 100, 128, 40, 1.0f);
  ExpectRefused(border, "cloth touches the border at the left (40 px about row 120)");
  std::mt19937 random(3);
  for (float& c : noise.coverage) c = random() % 2 == 0 ? 1.0f : 0.0f;
  ExpectRefused(noise, "a.png");
  for (float& c : speckled.coverage) c = random() % 20 == 0 ? 1.0f : c;
  ExpectRefused(speckled, "is noise: ");
  ExpectRefused(GrayImage(15, 40), "at least 16x16");
  ExpectRefused(GrayImage(40, 40), "no cloth");
  ExpectRefused(GrayImage(40, 40, 1.0f), "no background");
  GrayImage odd = Star();
  odd.at(3, 3) = std::nanf("");
  ExpectRefused(odd, "not in [0, 1]");
}

}  // namespace
}  // namespace drape
