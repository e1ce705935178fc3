// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <vector>

#include "cuda/factor/plan/nested_dissection.h"

namespace drape {
namespace {

template <class Joined>
VertexGraph GraphWhere(int vertices, Joined&& joined) {
  VertexGraph graph;
  graph.start.push_back(0);
  for (int v = 0; v < vertices; ++v) {
    for (int w = 0; w < vertices; ++w)
      if (v != w && joined(v, w)) graph.neighbour.push_back(w);
    graph.start.push_back(static_cast<int>(graph.neighbour.size()));
  }
  return graph;
}

constexpr int kRows = 6, kColumns = 30;

VertexGraph Grid() {
  return GraphWhere(kRows * kColumns, [](int v, int w) {
    return std::abs(v % kRows - w % kRows) + std::abs(v / kRows - w / kRows) == 1;
  });
}

Eigen::Matrix2Xd GridPlaces() {
  Eigen::Matrix2Xd uv(2, kRows * kColumns);
  for (int v = 0; v < uv.cols(); ++v) uv.col(v) << v / kRows, v % kRows;
  return uv;
}

void ExpectSeparates(const VertexGraph& graph, const Cut& cut) {
  ASSERT_TRUE(cut.found());
  for (int v = 0; v < graph.num_vertices(); ++v)
    for (int k = graph.start[v]; k < graph.start[v + 1]; ++k)
      EXPECT_NE(cut.side[v] + cut.side[graph.neighbour[k]], 1);
  EXPECT_EQ(cut.score, CutScore(cut.side));
}

int SeparatorSize(const Cut& cut) {
  return static_cast<int>(std::count(cut.side.begin(), cut.side.end(), Cut::kSeparator));
}

TEST(StraightCut, CutsAGridAcross) {
  const Cut cut = StraightCut(Grid(), GridPlaces());
  ExpectSeparates(Grid(), cut);
  EXPECT_EQ(SeparatorSize(cut), kRows);
}

// Two stars whose centres lie on opposite sides of the middle of a line.
TEST(StraightCut, SeparatorIsAMinimalCover) {
  const VertexGraph stars = GraphWhere(12, [](int v, int w) {
    const auto [a, b] = std::minmax(v, w);
    return (a == 0 && b >= 6 && b <= 8) || (a >= 1 && a <= 3 && b == 11);
  });
  Eigen::Matrix2Xd uv = Eigen::Matrix2Xd::Zero(2, 12);
  for (int v = 0; v < 12; ++v) uv(0, v) = v;
  const Cut cut = StraightCut(stars, uv);
  ExpectSeparates(stars, cut);
  EXPECT_EQ(SeparatorSize(cut), 2);
  EXPECT_EQ(cut.side[0], Cut::kSeparator);
  EXPECT_EQ(cut.side[11], Cut::kSeparator);
}

TEST(StraightCut, NoneWhereAllVerticesLieTogether) {
  EXPECT_FALSE(StraightCut(Grid(), Eigen::Matrix2Xd::Zero(2, kRows * kColumns)).found());
}

TEST(MetisCut, CutsAGridAcross) {
  const Cut cut = MetisCut(Grid());
  ExpectSeparates(Grid(), cut);
  EXPECT_LE(SeparatorSize(cut), kRows);
}

TEST(MetisCut, NoneOfACompleteGraph) {
  EXPECT_FALSE(MetisCut(GraphWhere(60, [](int, int) { return true; })).found());
}

TEST(CutScore, PenalisesUnequalSides) {
  EXPECT_DOUBLE_EQ(CutScore({0, 2, 1}), 1.0);
  EXPECT_DOUBLE_EQ(CutScore({0, 0, 0, 0, 0, 0, 0, 2, 2, 1}), 2 * (1 + 0.6 * 0.2));
  EXPECT_TRUE(std::isinf(CutScore({0, 0, 2})));
  EXPECT_TRUE(std::isinf(CutScore({2, 1, 1})));
}

// METIS has one random number generator for all threads. (Without the lock of MetisCut some of
// these differ on each run.)
TEST(MetisCut, CutsOfSeveralThreadsAreThoseOfOne) {
  const VertexGraph graph = GraphWhere(
      600, [](int v, int w) { return std::abs(v % 20 - w % 20) + std::abs(v / 20 - w / 20) == 1; });
  const Cut alone = MetisCut(graph);
  constexpr int kThreads = 4, kCuts = 8;
  std::vector<Cut> cuts(kThreads * kCuts);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < kThreads; ++t)
      threads.emplace_back([&, t] {
        for (int k = 0; k < kCuts; ++k) cuts[t * kCuts + k] = MetisCut(graph);
      });
  }
  for (const Cut& cut : cuts) EXPECT_EQ(cut.side, alone.side);
}

}  // namespace
}  // namespace drape
