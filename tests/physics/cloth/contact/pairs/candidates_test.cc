// SPDX-License-Identifier: Apache-2.0
// Two parts of a cloth that can touch: distance, derivatives, safe moves and search.
#include "physics/cloth/contact/pairs/candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "physics/cloth/contact/pairs/contact_pair.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/util/math/random.h"
#include "tests/physics/cloth/contact/closed_mesh.h"

namespace drape {
namespace {

PairColumns RandomColumns(std::mt19937_64& random, double scale) {
  PairColumns columns;
  for (double& part : columns.reshaped()) part = scale * SampleNormal(random);
  return columns;
}

// Which corners the nearest points lie between, a bit for each.
int Feature(const PairDistance& distance) {
  int feature = 0;
  for (int i = 0; i < 4; ++i) feature |= (distance.weight[i] != 0.0) << i;
  return feature;
}

// The derivative of `function` at x by central differences, a column for each coordinate.
template <typename Function>
Eigen::MatrixXd Differences(const Function& function, const PairColumns& x, double step) {
  Eigen::MatrixXd columns(function(x).size(), 12);
  for (int i = 0; i < 12; ++i) {
    PairColumns more = x, less = x;
    more.reshaped()[i] += step;
    less.reshaped()[i] -= step;
    columns.col(i) = (function(more) - function(less)) / (2.0 * step);
  }
  return columns;
}

Eigen::VectorXd DistanceGradient(bool of_edges, const PairColumns& x) {
  const PairDistance distance = MeasureDistance(of_edges, x);
  return (distance.normal * distance.weight.transpose()).reshaped();
}

TEST(Pairs, DistanceIsTheLeastOfAllPoints) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 400; ++k) {
    const bool of_edges = k % 2 == 0;
    const PairColumns x = RandomColumns(random, 1.0);
    const double found = MeasureDistance(of_edges, x).value;
    constexpr int kParts = 200;
    double least = 1e9;
    for (int i = 0; i <= kParts; ++i)
      for (int j = 0; j <= (of_edges ? kParts : kParts - i); ++j) {
        const double s = 1.0 * i / kParts, t = 1.0 * j / kParts;
        const Eigen::Vector4d weight = of_edges ? Eigen::Vector4d(1.0 - s, s, t - 1.0, -t)
                                                : Eigen::Vector4d(1.0, s + t - 1.0, -s, -t);
        least = std::min(least, (x * weight).norm());
      }
    EXPECT_LE(found, least + 1e-12) << k;
    EXPECT_GT(found, least - 0.05) << k;
  }
}

TEST(Pairs, CurvatureOfTheDistanceIsItsSecondDerivative) {
  std::mt19937_64 random(2);
  std::map<std::pair<bool, int>, int> seen;
  for (int k = 0; k < 600; ++k) {
    const bool of_edges = k % 2 == 0;
    const PairColumns x = RandomColumns(random, 1.0);
    const PairDistance distance = MeasureDistance(of_edges, x);
    const auto gradient = [&](const PairColumns& y) { return DistanceGradient(of_edges, y); };
    const Eigen::MatrixXd expected = Differences(gradient, x, 1e-6);
    // Not where a step changes the features.
    const Eigen::MatrixXd finer = Differences(gradient, x, 5e-7);
    if ((expected - finer).norm() > 1e-4 * expected.norm()) continue;
    const PairMatrix curvature = DistanceCurvature(of_edges, x, distance);
    EXPECT_LT((curvature - expected).norm(), 1e-5 * (1.0 + expected.norm())) << k;
    ++seen[{of_edges, Feature(distance)}];
  }
  // A face's corners, edges and interior; the ends and the interiors of two edges.
  EXPECT_EQ(seen.size(), 7U + 9U);
}

TEST(Pairs, TheMollifierHasItsDerivativesAndFades) {
  std::mt19937_64 random(3);
  int fading = 0;
  for (int k = 0; k < 200; ++k) {
    PairColumns x = RandomColumns(random, 1.0);
    const Eigen::Vector3d along = x.col(1) - x.col(0);
    const double angle = std::pow(10.0, -2.5 + 2.0 * k / 200.0);
    x.col(3) = x.col(2) + along +
               angle * along.norm() * Eigen::Vector3d(RandomColumns(random, 1.0).col(0));
    const double squares = along.squaredNorm() * (x.col(3) - x.col(2)).squaredNorm();
    const Mollifier mollifier = MollifyParallel(x, squares);
    EXPECT_GE(mollifier.value, 0.0);
    EXPECT_LE(mollifier.value, 1.0);
    fading += mollifier.value < 1.0;
    const Eigen::MatrixXd slope = Differences(
        [&](const PairColumns& y) {
          return Eigen::VectorXd::Constant(1, MollifyParallel(y, squares).value);
        },
        x, 1e-7);
    EXPECT_LT((slope.transpose() - mollifier.gradient.reshaped()).norm(),
              1e-5 * (1.0 + slope.norm()))
        << k;
    const Eigen::MatrixXd curvature = Differences(
        [&](const PairColumns& y) -> Eigen::VectorXd {
          return MollifyParallel(y, squares).gradient.reshaped();
        },
        x, 1e-7);
    EXPECT_LT((curvature - MollifierCurvature(x, squares)).norm(), 1e-4 * (1.0 + curvature.norm()))
        << k;
  }
  EXPECT_GT(fading, 30);
  EXPECT_LT(fading, 170);
  PairColumns parallel = PairColumns::Zero();
  parallel.col(1) << 1.0, 0.0, 0.0;
  parallel.col(2) << 0.2, 0.1, 0.0;
  parallel.col(3) << 1.2, 0.1, 0.0;
  EXPECT_EQ(MollifyParallel(parallel, 1.0).value, 0.0);
}

// On the whole way a tenth of the gap is left, by many samples; and a share is not shortened for
// nothing: at its end the parts are near one another, or it is 1.
TEST(Pairs, SafeSharesKeepATenthOfTheGap) {
  std::mt19937_64 random(4);
  int shortened = 0;
  for (int k = 0; k < 20000; ++k) {
    const bool of_edges = k % 2 == 0;
    const PairColumns x = RandomColumns(random, 1.0);
    const double moves = std::pow(10.0, std::uniform_real_distribution(-3.0, 1.0)(random));
    const PairColumns dx = RandomColumns(random, moves);
    const double distance = MeasureDistance(of_edges, x).value;
    const double thickness = std::uniform_real_distribution(0.0, 1.2)(random) * distance;
    const double gap = distance > thickness ? distance - thickness : distance;
    const double kept = distance - 0.9 * gap, share = SafeShare(of_edges, x, dx, thickness);
    ASSERT_GE(share, 0.0);
    ASSERT_LE(share, 1.0);
    double least = distance;
    for (int i = 1; i <= 100; ++i)
      least = std::min(least, MeasureDistance(of_edges, x + 0.01 * i * share * dx).value);
    ASSERT_GE(least, kept * (1.0 - 1e-12)) << k;
    if (share == 1.0) continue;
    ++shortened;
    EXPECT_LT(MeasureDistance(of_edges, x + share * dx).value, kept + 0.1 * gap) << k;
  }
  EXPECT_GT(shortened, 2000);
}

// A move that jumps through the other part is stopped before it.
TEST(Pairs, NothingTunnels) {
  PairColumns x, dx = PairColumns::Zero();
  x.col(0) << 0.2, 0.2, 1.0;
  x.col(1) << 0.0, 0.0, 0.0;
  x.col(2) << 1.0, 0.0, 0.0;
  x.col(3) << 0.0, 1.0, 0.0;
  dx.col(0) << 0.0, 0.0, -1e6;
  const double share = SafeShare(false, x, dx, 0.1);
  EXPECT_NEAR(share * 1e6, 0.9 * 0.9, 0.02 * 0.9);
}

std::vector<std::array<int, 2>> ListEnds(const Mesh& mesh) {
  std::vector<std::array<int, 2>> edges;
  for (const RestEdge& edge : ListEdges(mesh)) edges.push_back({edge.vertex[0], edge.vertex[1]});
  return edges;
}

// By all pairs of a crumpled strip, for shapes that wander.
TEST(Pairs, TheSearchFindsAllThatAreNear) {
  constexpr double kReach = 0.02;
  const Mesh mesh = MakeStrip(0.3, 0.1, 12, 5);
  const auto edges = ListEnds(mesh);
  const auto triangles = ListTriangles(mesh);
  std::vector<int> vertices(mesh.num_vertices());
  std::iota(vertices.begin(), vertices.end(), 0);
  PairCandidates candidates({.vertices = vertices, .edges = edges, .triangles = triangles}, kReach);
  std::mt19937_64 random(5);
  Eigen::VectorXd x = mesh.rest_x;
  std::size_t most = 0;
  for (int step = 0; step < 60; ++step) {
    Eigen::VectorXd dx(x.size());
    const double moves = step % 3 == 0 ? 2e-2 : 2e-4;
    for (double& part : dx) part = moves * SampleNormal(random);
    candidates.UseThreads(step % 2 == 0 ? 1 : 3);
    candidates.Cover(x, dx);
    for (const double share : {0.0, 0.5, 1.0}) {
      const Eigen::VectorXd at = x + share * dx;
      std::set<ContactPair> found;
      for (const auto& [distance, pair] : candidates.Near(at, 0.0))
        if (MeasureDistance(pair.of_edges, GatherPair(pair, at)).value < kReach) found.insert(pair);
      std::set<ContactPair> expected;
      const auto look = [&](const ContactPair& pair) {
        if (std::set<int>(pair.vertex.begin(), pair.vertex.end()).size() == 4 &&
            MeasureDistance(pair.of_edges, GatherPair(pair, at)).value < kReach)
          expected.insert(pair);
      };
      for (int i = 0; i < mesh.num_vertices(); ++i)
        for (const auto& [a, b, c] : triangles) look({false, {i, a, b, c}});
      for (std::size_t i = 0; i < edges.size(); ++i)
        for (std::size_t j = i + 1; j < edges.size(); ++j)
          look({true, {edges[i][0], edges[i][1], edges[j][0], edges[j][1]}});
      ASSERT_EQ(found, expected) << step << " " << share;
      most = std::max(most, found.size());
    }
    x += dx;
  }
  EXPECT_GT(most, 100U);
}

// The same for a ball that wanders around the strip, of which pairs with itself are not wanted.
TEST(Pairs, TheSearchFindsAllThatAreNearAnObstacle) {
  constexpr double kReach = 0.02;
  const Mesh mesh = MakeStrip(0.3, 0.1, 12, 5);
  const test::ClosedMesh ball = test::MakeBall(0.04, 1);
  const int cloth = mesh.num_vertices(), all = cloth + static_cast<int>(ball.x.cols());
  SurfaceParts strip{.edges = ListEnds(mesh), .triangles = ListTriangles(mesh)}, around;
  for (int i = 0; i < all; ++i) (i < cloth ? strip : around).vertices.push_back(i);
  for (const auto& [p, q, r] : ball.triangles) {
    around.triangles.push_back({cloth + p, cloth + q, cloth + r});
    for (const auto& [a, b] : {std::array{p, q}, {q, r}, {r, p}})
      if (a < b) around.edges.push_back({cloth + a, cloth + b});
  }
  PairCandidates candidates(strip, kReach, false);
  candidates.SetObstacles(around, kReach);
  std::mt19937_64 random(9);
  std::size_t most = 0;
  Eigen::VectorXd x(3 * all);
  x << mesh.rest_x, (ball.x.colwise() + Eigen::Vector3d(0.05, 0.05, 0.03)).reshaped();
  for (int step = 0; step < 30; ++step) {
    Eigen::VectorXd dx(x.size());
    for (double& part : dx) part = 2e-3 * SampleNormal(random);
    dx.tail(ball.x.size()) += Eigen::Vector3d(5e-3, 0.0, 0.0).replicate(ball.x.cols(), 1);
    candidates.Cover(x, dx);
    x += dx;
    std::set<ContactPair> found, expected;
    for (const auto& [distance, pair] : candidates.Near(x, 0.0))
      if (MeasureDistance(pair.of_edges, GatherPair(pair, x)).value < kReach) found.insert(pair);
    const auto look = [&](const ContactPair& pair) {
      if (MeasureDistance(pair.of_edges, GatherPair(pair, x)).value < kReach) expected.insert(pair);
    };
    for (const int i : strip.vertices)
      for (const auto& [a, b, c] : around.triangles) look({false, {i, a, b, c}});
    for (const int i : around.vertices)
      for (const auto& [a, b, c] : strip.triangles) look({false, {i, a, b, c}});
    for (const auto& [a, b] : strip.edges)
      for (const auto& [c, d] : around.edges) look({true, {a, b, c, d}});
    ASSERT_EQ(found, expected) << step;
    most = std::max(most, found.size());
  }
  EXPECT_GT(most, 100U);
}

class BoxTreeTest : public testing::TestWithParam<int> {
 protected:
  SpaceBox RandomBox(double size) {
    SpaceBox box;
    for (int k = 0; k < 3; ++k) {
      box.min()[k] = SampleUniform(random_);
      box.max()[k] = box.min()[k] + size * SampleUniform(random_);
    }
    return box;
  }
  std::vector<SpaceBox> RandomBoxes(double size) {
    std::vector<SpaceBox> boxes;
    for (int i = 0; i < GetParam(); ++i) boxes.push_back(RandomBox(size));
    return boxes;
  }
  // No two of these boxes are nearer than single precision can tell.
  static void ExpectFinds(const BoxTree& tree, const std::vector<SpaceBox>& boxes,
                          const SpaceBox& box) {
    std::vector<int> found(boxes.size(), 0);
    tree.ForEachMeeting(box, [&](int k) { ++found[k]; });
    for (std::size_t k = 0; k < boxes.size(); ++k)
      EXPECT_EQ(found[k], boxes[k].intersects(box)) << k;
  }

  std::mt19937_64 random_{4};
};

TEST_P(BoxTreeTest, FindsAllThatMeetAndNoOthersAlsoAfterTheyHaveMoved) {
  BoxTree tree;
  for (int round = 0; round < 3; ++round) {
    const std::vector<SpaceBox> boxes = RandomBoxes(0.2);
    tree.Enclose(boxes);
    for (int k = 0; k < 20; ++k) ExpectFinds(tree, boxes, RandomBox(0.4));
  }
}

TEST_P(BoxTreeTest, VisitsEachPairOnce) {
  const std::vector<SpaceBox> boxes = RandomBoxes(0.2);
  BoxTree tree;
  tree.Enclose(boxes);
  ASSERT_EQ(tree.order().size(), boxes.size());
  std::vector<std::pair<int, int>> found, expected;
  for (int place = 0; place < GetParam(); ++place) {
    const int one = tree.order()[place];
    tree.ForEachLaterMeeting(
        place, [&](int other) { found.emplace_back(std::min(one, other), std::max(one, other)); });
  }
  for (int i = 0; i < GetParam(); ++i)
    for (int j = i + 1; j < GetParam(); ++j)
      if (boxes[i].intersects(boxes[j])) expected.emplace_back(i, j);
  EXPECT_THAT(found, testing::UnorderedElementsAreArray(expected));
}

INSTANTIATE_TEST_SUITE_P(Numbers, BoxTreeTest, testing::Values(0, 1, 2, 7, 8, 9, 63, 64, 65, 700));

// Rounded outwards: boxes that only just meet are found, wherever they are.
TEST(BoxTreeRoundingTest, LosesNoneThatTouch) {
  for (const double at : {0.1, -3.0, 1e4}) {
    const SpaceBox left(Eigen::Vector3d(at - 1.0, 0.0, 0.0), Eigen::Vector3d(at, 1.0, 1.0));
    const SpaceBox right(Eigen::Vector3d(at, 0.0, 0.0), Eigen::Vector3d(at + 1.0, 1.0, 1.0));
    BoxTree tree;
    tree.Enclose({left});
    int found = 0;
    tree.ForEachMeeting(right, [&](int) { ++found; });
    EXPECT_EQ(found, 1) << at;
  }
}

}  // namespace
}  // namespace drape
