// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "physics/util/math/statistics.h"

namespace drape {
namespace {

TEST(FitPowerLaw, FindsExponentAndFactor) {
  const std::vector<double> x = {1, 2, 4}, y = {3, 3 * std::pow(2, 1.5), 3 * std::pow(4, 1.5)};
  const auto law = FitPowerLaw(x, y);
  ASSERT_TRUE(law);
  EXPECT_NEAR(law->exponent, 1.5, 1e-12);
  EXPECT_NEAR(law->factor, 3.0, 1e-12);
}

TEST(FitPowerLaw, NeedsTwoDistinctPoints) {
  const std::vector<double> x = {2, 2}, y = {1, 3};
  EXPECT_FALSE(FitPowerLaw(x, y));
  EXPECT_FALSE(FitPowerLaw(std::span(x).first(1), std::span(y).first(1)));
  EXPECT_FALSE(FitPowerLaw({}, {}));
}

}  // namespace
}  // namespace drape
