// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "physics/material/material_scaling.h"

namespace drape {
namespace {

TEST(LaboratoryStiffness, AveragesWarpAndWeft) {
  EXPECT_DOUBLE_EQ(OverallStiffness(4.0, 9.0), 6.0);
}

// 1 gf·cm²/cm = 98.07 µN·m, 1 gf/(cm·°) = 56.19 N/m.
TEST(LaboratoryStiffness, ConvertsToKes) {
  EXPECT_NEAR(KesBending(98.07e-6), 1.0, 1e-4);
  EXPECT_NEAR(KesShear(56.19), 1.0, 1e-4);
  EXPECT_NEAR(ExtensionPercent(kKesForce, 4903.325), 10.0, 1e-12);
}

TEST(LaboratoryStiffness, FollowsFast) {
  EXPECT_NEAR(ExtensionPercent(kFastForces[2], 980.665), 10.0, 1e-12);
  EXPECT_DOUBLE_EQ(FastBiasExtensionPercent(41.0), 3.0);
  EXPECT_NEAR(FormabilityMm2(7.35e-6, 0.5, 2.5), 1.0, 1e-12);
}

}  // namespace
}  // namespace drape
