// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "losses/camera/camera.h"
#include "losses/image/image.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

constexpr DrapeDiscs kSmall = {0.12, 0.09}, kLarge = {0.18, 0.09};

class FindDiscsTest : public FileFixture {
 protected:
  std::string Image(const std::string& name, const std::optional<DrapeDiscs>& discs) const {
    WritePng(GrayImage(16, 16), Path(name), discs);
    return Path(name);
  }
};

TEST_F(FindDiscsTest, AreThoseOfTheFilesAndOfTheUser) {
  const std::string none = Image("none.png", {}), small = Image("small.png", kSmall);
  EXPECT_EQ(FindDiscs({}), DrapeDiscs());
  EXPECT_EQ(FindDiscs({}, {none, Path("no file")}), DrapeDiscs());
  EXPECT_EQ(FindDiscs({}, {none, small}), kSmall);
  EXPECT_EQ(FindDiscs({.specimen = 0.24}, {small}), kSmall);
  EXPECT_EQ(FindDiscs({.specimen = 0.254, .support = 0.127}), (DrapeDiscs{0.127, 0.0635}));
  EXPECT_EQ(FindDiscs(GivenDiscs(kLarge)), kLarge);
}

TEST_F(FindDiscsTest, AFileOfJsonSaysThemToo) {
  const std::string json = Write("camera.json", DiscsJson(kLarge).dump());
  EXPECT_EQ(FindDiscs({}, {json}), kLarge);
  EXPECT_EQ(FindDiscs({}, {Write("other.json", "{\"kind\": 1}")}), DrapeDiscs());
  EXPECT_INPUT_ERROR(
      FindDiscs(
          {}, {Write("bad.json", "{\"specimen_diameter_m\": 0.1, \"support_diameter_m\": 0.18}")}),
      "bad.json: found 10 cm on 18 cm, expected a support that is smaller");
}

TEST_F(FindDiscsTest, ThoseThatDifferAreNeverCompared) {
  const std::string small = Image("small.png", kSmall), large = Image("large.png", kLarge);
  EXPECT_INPUT_ERROR(FindDiscs({}, {small, large}),
                     "large.png: is of a specimen of 36 cm on 18 cm, expected 24 cm on 18 cm as ");
  EXPECT_INPUT_ERROR(FindDiscs({.specimen = 0.3}, {small}),
                     "small.png: is of a specimen of 24 cm on 18 cm, expected 30 cm on 18 cm as "
                     "options");
  EXPECT_INPUT_ERROR(FindDiscs({.support = 0.3}),
                     "option 'support': found 30 cm on 30 cm, expected a support that is smaller");
}

// The scale of the published images is known for pictures of the size that a specimen needs.
TEST(CameraAbove, HoldsTheFlatSpecimen) {
  EXPECT_EQ(CameraAbove(kSmall).width, 256);
  EXPECT_EQ(CameraAbove({}).width, 256);
  const Camera camera = CameraAbove(kLarge);
  EXPECT_EQ(camera.width, 308);
  EXPECT_EQ(camera.cx, 153.5);
  EXPECT_EQ(camera.pixels_per_metre(), 719.5);
  EXPECT_EQ(MakeCamera(CameraInput(), kLarge).width, 308);
  EXPECT_EQ(MakeCamera({}, GrayImage(308, 308), kLarge, "a.png").cy, 153.5);
  EXPECT_INPUT_ERROR(MakeCamera({}, GrayImage(308, 308), {}, "a.png"), "its scale is not given");
}

}  // namespace
}  // namespace drape
