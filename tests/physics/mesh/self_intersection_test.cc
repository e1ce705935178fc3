// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/self_intersection.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <vector>

namespace drape {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using Triangles = std::vector<std::array<int, 3>>;

Eigen::VectorXd Positions(const std::vector<Eigen::Vector3d>& points) {
  Eigen::VectorXd x(3 * points.size());
  for (size_t i = 0; i < points.size(); ++i) x.segment<3>(3 * i) = points[i];
  return x;
}

// A tetrahedron shares edges and vertices, which are no intersections.
const Triangles kTetrahedron = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
const std::vector<Eigen::Vector3d> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

TEST(SelfIntersection, ATetrahedronHasNone) {
  EXPECT_THAT(FindSelfIntersections(kTetrahedron, Positions(kCorners), 10), IsEmpty());
}

TEST(SelfIntersection, FindsCrossingTrianglesWithoutCommonVertices) {
  const auto crossing = [](double z) {
    return Positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.2, .2, z}, {.3, .2, z}, {.2, .3, z + 1}});
  };
  const Triangles triangles = {{0, 1, 2}, {3, 4, 5}};
  EXPECT_THAT(FindSelfIntersections(triangles, crossing(-.5)), ElementsAre(Pair(0, 1)));
  EXPECT_THAT(FindSelfIntersections(triangles, crossing(0)), ElementsAre(Pair(0, 1)));  // touch
  EXPECT_THAT(FindSelfIntersections(triangles, crossing(1e-300)), IsEmpty());
}

TEST(SelfIntersection, FindsTrianglesThatShareAVertexAndCross) {
  const auto pair = [](double z) {
    return Positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.5, .4, z}, {.4, .5, z + 1}});
  };
  EXPECT_THAT(FindSelfIntersections({{0, 1, 2}, {3, 4, 0}}, pair(-.5)), ElementsAre(Pair(0, 1)));
  EXPECT_THAT(FindSelfIntersections({{0, 1, 2}, {3, 4, 0}}, pair(.1)), IsEmpty());
}

TEST(SelfIntersection, FindsTrianglesThatAreFoldedOntoTheirNeighbour) {
  const auto hinge = [](double y) {
    return Positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.5, y, 0}});
  };
  EXPECT_THAT(FindSelfIntersections({{0, 1, 2}, {1, 0, 3}}, hinge(.5)), ElementsAre(Pair(0, 1)));
  EXPECT_THAT(FindSelfIntersections({{0, 1, 2}, {1, 0, 3}}, hinge(-.5)), IsEmpty());
}

TEST(SelfIntersection, NamesTrianglesWithoutArea) {
  const auto x = Positions({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 5, 0}, {1, 5, 0}, {0, 6, 0}});
  EXPECT_THAT(FindSelfIntersections({{3, 4, 5}, {0, 1, 2}}, x), ElementsAre(Pair(1, 1)));
}

TEST(SelfIntersection, ReportsAtMostAsManyAsAskedForInOrder) {
  std::vector<Eigen::Vector3d> points;
  Triangles triangles;
  for (int k = 0; k < 5; ++k) {  // five planes through one axis
    const double angle = .3 * k;
    const Eigen::Vector3d side(std::cos(angle), std::sin(angle), 0);
    points.insert(points.end(), {-side, side, {.01 * k, 0, 3}});
    triangles.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  const auto all = FindSelfIntersections(triangles, Positions(points), 100);
  EXPECT_EQ(all.size(), 10u);
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
  EXPECT_THAT(FindSelfIntersections(triangles, Positions(points), 2),
              ElementsAre(Pair(0, 1), Pair(0, 2)));
}

}  // namespace
}  // namespace drape
