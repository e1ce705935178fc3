// SPDX-License-Identifier: Apache-2.0
#include "losses/image/photo_planes.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

namespace drape {
namespace {

using Eigen::Vector3f;

// What a camera sees of that share of the second light: red, green, blue and the light of the luma.
Eigen::Vector4f Mixture(const Vector3f& first, const Vector3f& second, float share) {
  const Vector3f light = (1 - share) * first + share * second;
  Eigen::Vector4f seen;
  seen << light, LumaLight(light.cast<double>().unaryExpr(&StoredFromLight).cast<float>());
  return seen;
}

TEST(Light, IsThatOfTheStandard) {
  const std::array<float, 256>& light = LightOfStored();
  EXPECT_FLOAT_EQ(light[0], 0);
  EXPECT_FLOAT_EQ(light[255], 1);
  EXPECT_NEAR(light[188], 0.5029, 1e-4);
  const RgbImage image{2, 2, {0, 0, 0, 255, 255, 255, 0, 0, 0, 255, 255, 255}};
  EXPECT_NEAR(LightAt(image, {0.25, 0.5}).x(), 0.25, 1e-6);
}

TEST(Light, GoesToStoredValuesAndBack) {
  EXPECT_NEAR(LightFromStored(0.5), 0.214041, 1e-6);
  EXPECT_NEAR(LightFromStored(0.04), 0.04 / 12.92, 1e-15);
  for (const double stored : {0.0, 0.03, 0.2, 0.7, 1.0})
    EXPECT_NEAR(StoredFromLight(LightFromStored(stored)), stored, 1e-12) << stored;
}

TEST(Light, LumaOfGreyIsItsLight) {
  for (const float light : {0.001f, 0.02f, 0.3f, 0.9f})
    EXPECT_NEAR(LumaLight(Vector3f::Constant(static_cast<float>(StoredFromLight(light)))), light,
                1e-5f)
        << light;
}

TEST(Light, TheShareOfAMixtureIsFound) {
  const Vector3f ground(0.5f, 0.48f, 0.45f), lilac(0.35f, 0.2f, 0.4f);
  const Vector3f green(0.2f, 0.52f, 0.2f);  // of nearly the ground's luma
  for (const Vector3f& cloth : {lilac, green})
    for (const float share : {0.0f, 0.1f, 0.4f, 0.5f, 0.85f, 1.0f})
      EXPECT_NEAR(ShareOfMixture(Mixture(ground, cloth, share), ground, cloth - ground), share,
                  2e-3f)
          << cloth.transpose() << ": " << share;
}

// A JPEG file has the colour of four pixels together: that of the pixel beside an edge is wrong,
// its luma is not.
TEST(Light, TheShareIsThatOfTheLumaWhereColoursAreBlurred) {
  const Vector3f ground(0.5f, 0.48f, 0.45f), cloth(0.35f, 0.2f, 0.4f);
  Eigen::Vector4f seen = Mixture(ground, cloth, 0.3f);
  seen.head<3>() = Mixture(ground, cloth, 0.6f).head<3>();
  EXPECT_NEAR(ShareOfMixture(seen, ground, cloth - ground), 0.3f, 2e-3f);
}

// An exception of OpenCV is reported as what it is: a fault of this program, with its cause.
TEST(CatchOpenCv, NamesTheCause) {
  try {
    CatchOpenCv([] { cv::resize(cv::Mat(), cv::Mat1b(3, 3), {}); });
    ADD_FAILURE() << "nothing was thrown";
  } catch (const PhotoFailure& failure) {
    EXPECT_STREQ(ToString(failure.fault), "fault of this program");
    EXPECT_THAT(failure.reason, testing::AllOf(testing::HasSubstr("OpenCV says \""),
                                               testing::HasSubstr("in resize")));
  }
}

}  // namespace
}  // namespace drape
