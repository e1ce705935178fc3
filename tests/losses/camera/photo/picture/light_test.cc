// SPDX-License-Identifier: Apache-2.0
#include "losses/camera/photo/picture/light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace drape {
namespace {

using Eigen::Vector3f;

float StoredValue(float light) {
  return light <= 0.0031308f ? 12.92f * light : 1.055f * std::pow(light, 1 / 2.4f) - 0.055f;
}

// What a camera sees of that share of the second light: red, green, blue and the light of the luma.
Eigen::Vector4f Mixture(const Vector3f& first, const Vector3f& second, float share) {
  const Vector3f light = (1 - share) * first + share * second;
  Eigen::Vector4f seen;
  seen << light, LumaLight(light.unaryExpr(&StoredValue));
  return seen;
}

TEST(Light, LumaOfGreyIsItsLight) {
  for (const float light : {0.001f, 0.02f, 0.3f, 0.9f})
    EXPECT_NEAR(LumaLight(Vector3f::Constant(StoredValue(light))), light, 1e-5f) << light;
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

}  // namespace
}  // namespace drape
