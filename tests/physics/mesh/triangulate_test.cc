// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/triangulate.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace drape {
namespace {

using ::testing::ElementsAre;

// A flat rhombus: the Delaunay criterion joins 2 and 3, its short diagonal.
Eigen::Matrix2Xd Rhombus() {
  Eigen::Matrix2Xd points(2, 4);
  points << 0, 4, 2, 2,  //
      0, 0, .5, -.5;
  return points;
}

TEST(Triangulate, IsDelaunayAndCounterClockwise) {
  EXPECT_THAT(Triangulate(Rhombus(), {}), ElementsAre(ElementsAre(0, 3, 2), ElementsAre(1, 2, 3)));
}

TEST(Triangulate, KeepsTheEdgesAskedFor) {
  EXPECT_THAT(Triangulate(Rhombus(), {{0, 1}}),
              ElementsAre(ElementsAre(0, 1, 2), ElementsAre(0, 3, 1)));
}

TEST(SpatialOrder, VisitsEachPointOnceInShortSteps) {
  Eigen::Matrix2Xd points(2, 400);
  for (int i = 0; i < 400; ++i) points.col(i) << (i * 7) % 20, (i * 7 / 20) % 20;
  const std::vector<int> order = SpatialOrder(points);
  std::vector<int> sorted = order, all(400);
  std::iota(all.begin(), all.end(), 0);
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, all);
  double length = 0;
  for (int i = 1; i < 400; ++i) length += (points.col(order[i]) - points.col(order[i - 1])).norm();
  EXPECT_LT(length / 399, 1.5);  // in random order the mean step is over 10
}

}  // namespace
}  // namespace drape
