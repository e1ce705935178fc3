// SPDX-License-Identifier: Apache-2.0
#include "physics/util/math/statistics.h"

#include <gtest/gtest.h>

#include <limits>

namespace drape {
namespace {

TEST(Quantile, IsLinearBetweenNeighbours) {
  const std::vector<double> sorted = {1.0, 2.0, 4.0, 8.0};
  EXPECT_DOUBLE_EQ(Quantile(sorted, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(Quantile(sorted, 1.0), 8.0);
  EXPECT_DOUBLE_EQ(Quantile(sorted, 0.5), 3.0);
  EXPECT_DOUBLE_EQ(Quantile(sorted, 0.25), 1.75);
  EXPECT_DOUBLE_EQ(Quantile(sorted, 0.9), 6.8);
  EXPECT_DOUBLE_EQ(Quantile({5.0}, 0.3), 5.0);
}

TEST(Quantile, MayBeInfinite) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<double> sorted = {1.0, 2.0, kInfinity, kInfinity};
  EXPECT_DOUBLE_EQ(Quantile(sorted, 0.25), 1.75);
  EXPECT_EQ(Quantile(sorted, 0.5), kInfinity);
  EXPECT_EQ(Quantile(sorted, 0.9), kInfinity);
}

}  // namespace
}  // namespace drape
