// SPDX-License-Identifier: Apache-2.0
// What a job of a fit refuses, and how it says so.
#include <gmock/gmock.h>

#include <limits>

#include "tests/physics/file_fixture.h"
#include "tests/solver/job/fit_job_fixture.h"

namespace drape {
namespace {

using test::FitJobTest;
using testing::HasSubstr;

TEST_F(FitJobTest, TwoImagesOfOneNameAreRefused) {
  AddImage("other/a.png", DrapeImage());
  EXPECT_THAT(ComputeError(),
              testing::AllOf(HasSubstr("other/a.png"), HasSubstr("distinct names")));
}

TEST_F(FitJobTest, BadImagesAreNamed) {
  GrayImage border = DrapeImage();
  for (int row = 100; row < 140; ++row)
    for (int column = 0; column < 128; ++column) border.at(column, row) = 1.0f;
  AddImage("one_pixel.png", GrayImage(1, 1, 1.0f));
  AddImage("white.png", GrayImage(256, 256));
  AddImage("border.png", border);
  AddImage("corner.png", [] {
    GrayImage image(256, 256);
    for (int i = 5; i < 25; ++i)
      for (int j = 5; j < 25; ++j) image.at(i, j) = 1.0f;
    return image;
  }());
  WriteAll(folder_ / "empty.png", {});
  for (const std::string name : {"empty", "one_pixel", "white", "border", "corner", "absent"}) {
    data_.images = {folder_ / (name + ".png")};
    EXPECT_THAT(ComputeError(), HasSubstr(name + ".png")) << name;
  }
  EXPECT_FALSE(Exists("summary.json"));
}

TEST_F(FitJobTest, BadSettingsAreNamed) {
  data_.images.clear();
  EXPECT_THAT(ComputeError(), HasSubstr("images: found no silhouette"));
  AddImage("a.png", DrapeImage());
  MaterialField negative = test::TestMaterial();
  negative.stretch[0].c[0][1] = -1.0;
  WriteStart(negative);
  EXPECT_THAT(ComputeError(), HasSubstr("start.json"));
}

TEST(ParseName, KnowsTheNamesOfAnEnum) {
  EXPECT_EQ(ParseName<CentreMode>("nominal", "centre"), CentreMode::kNominal);
  EXPECT_EQ(ParseName<FitModel>(ToString(FitModel::kBdp), "model"), FitModel::kBdp);
  EXPECT_INPUT_ERROR(ParseName<CentreMode>("Outline", "centre"),
                     "centre: found 'Outline', expected one of nominal, outline");
}

}  // namespace
}  // namespace drape
