// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "tests/physics/simulation/closed_forms.h"

namespace drape {
namespace {

// The master curve of [Romero 2021] and the angle of [ASTM D1388], see [MODEL, M53].
TEST(HeavyElastica, FollowsThePublishedCurve) {
  const double curve[][2] = {{.1, .01250},  {.5, .06244},  {1, .12456},
                             {2, .24667},   {5, .58572},   {10, 1.06680},
                             {20, 1.86393}, {50, 3.70556}, {100, 5.88810}};
  for (const auto& [gamma, drop_by_reach] : curve)
    EXPECT_NEAR(HeavyElasticaGamma(std::atan(drop_by_reach)) / gamma, 1.0, 5e-4) << gamma;
  EXPECT_NEAR(HeavyElasticaGamma(41.5 * M_PI / 180.0), 8.0042, 1e-4);
}

// Values integrated independently; a narrow ring bends as a cantilever, w = L⁴/8.
TEST(AnnulusDeflection, AgreesWithTablesAndANarrowRing) {
  EXPECT_NEAR(AnnulusDeflection(0.6, 0.3), 3.508e-3, 1e-6);
  EXPECT_NEAR(AnnulusDeflection(0.6, 0.0), 3.834e-3, 1e-6);
  EXPECT_NEAR(AnnulusDeflection(0.6, -1.0 / 3.0), 4.324e-3, 1e-6);
  EXPECT_NEAR(AnnulusDeflection(0.99, 0.0) * 8e8, 1.0, 0.02);
}

TEST(DirectionalRigidity, IsTheTablesOwnWhereItIsIsotropic) {
  const MaterialField material = LinearMaterial(100.0, 3e-6, 0.2);
  for (const double direction : {0.0, 0.4, 1.5, -2.0})
    EXPECT_NEAR(DirectionalRigidity(material.bend[0], direction), 3e-6, 1e-18);
}

// A cloth bends along the weft by its hinges along the warp.
TEST(DirectionalRigidity, FollowsTheHingesAcross) {
  BendTable table;
  table.b[2][0] = kBendPerRigidity;
  EXPECT_GT(DirectionalRigidity(table, 0.0), 0.5);
  EXPECT_LT(DirectionalRigidity(table, M_PI / 2), 0.05);
}

}  // namespace
}  // namespace drape
