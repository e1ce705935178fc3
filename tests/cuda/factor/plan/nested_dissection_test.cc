// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/nested_dissection.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <thread>
#include <vector>

#include "physics/linalg/symbolic_analysis.h"
#include "tests/cuda/factor/plan/plan_fixture.h"

namespace drape {
namespace {

using testing::Each;

bool IsAbove(const std::vector<Separator>& nodes, int upper, int lower) {
  while (lower >= 0 && lower != upper) lower = nodes[lower].parent;
  return lower == upper;
}

// Each vertex in one node, children before parents, edges only between a node and those above it.
void ExpectDissects(const std::vector<Separator>& nodes, const BlockPattern& pattern) {
  std::vector<int> node(pattern.num_vertices(), -1);
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) {
    EXPECT_FALSE(nodes[i].vertices.empty());
    EXPECT_TRUE(nodes[i].parent == -1 || nodes[i].parent > i);
    for (const int v : nodes[i].vertices) {
      EXPECT_EQ(node[v], -1);
      node[v] = i;
    }
  }
  ASSERT_THAT(node, Each(testing::Ge(0)));
  for (int v = 0; v < pattern.num_vertices(); ++v)
    for (int b = pattern.row_start[v]; b < pattern.row_start[v + 1]; ++b) {
      const int a = node[v], c = node[pattern.column[b]];
      EXPECT_TRUE(IsAbove(nodes, a, c) || IsAbove(nodes, c, a)) << v << ' ' << pattern.column[b];
    }
}

int NumRoots(const std::vector<Separator>& nodes) {
  return static_cast<int>(
      std::count_if(nodes.begin(), nodes.end(), [](const auto& n) { return n.parent < 0; }));
}

TEST(NestedDissection, Discs) {
  for (const int vertices : {100, 300, 1500})
    for (const bool hinges : {false, true})
      for (const int leaf : {1, 24}) {
        const Mesh mesh = test::Disc(vertices);
        const BlockPattern pattern = MakeBlockPattern(mesh, true, hinges);
        const auto nodes = NestedDissection(pattern, mesh.uv, {leaf});
        ExpectDissects(nodes, pattern);
        EXPECT_EQ(NumRoots(nodes), 1);
        EXPECT_LT(nodes.back().vertices.size(), 4 * std::sqrt(vertices));
      }
}

TEST(NestedDissection, PartsThatAreNotJoinedHaveTheirOwnRoots) {
  const auto [pattern, uv] = test::TwoDiscs(200);
  const auto nodes = NestedDissection(pattern, uv, {});
  ExpectDissects(nodes, pattern);
  EXPECT_EQ(NumRoots(nodes), 2);
}

TEST(NestedDissection, SmallPartsAreLeavesTogether) {
  const auto [pattern, uv] = test::Isolated(60);
  const auto nodes = NestedDissection(pattern, uv, {});
  ExpectDissects(nodes, pattern);
  EXPECT_EQ(nodes.size(), 3U) << "24 + 24 + 12 vertices";
}

TEST(NestedDissection, GraphWithoutACutIsALeaf) {
  const auto [pattern, uv] = test::Complete(60);
  const auto nodes = NestedDissection(pattern, uv, {});
  ExpectDissects(nodes, pattern);
  EXPECT_EQ(nodes.size(), 1U);
}

// The tree of an order of elimination is a dissection too.
TEST(SeparatorsOfOrder, Discs) {
  for (const int vertices : {100, 300, 1500}) {
    const Mesh mesh = test::Disc(vertices);
    const BlockPattern pattern = MakeBlockPattern(mesh, true, true);
    const auto nodes = MakeSeparators(pattern, DissectVertices(pattern).vertex);
    ExpectDissects(nodes, pattern);
    EXPECT_EQ(NumRoots(nodes), 1);
    EXPECT_LT(nodes.back().vertices.size(), 4 * std::sqrt(vertices));
  }
}

TEST(SeparatorsOfOrder, PartsThatAreNotJoinedHaveTheirOwnRoots) {
  const BlockPattern pattern = test::TwoDiscs(200).pattern;
  const auto nodes = MakeSeparators(pattern, DissectVertices(pattern).vertex);
  ExpectDissects(nodes, pattern);
  EXPECT_EQ(NumRoots(nodes), 2);
}

TEST(SeparatorsOfOrder, VerticesWithTheSameColumnsAreTogether) {
  const BlockPattern pattern = test::Complete(60).pattern;
  EXPECT_EQ(MakeSeparators(pattern, DissectVertices(pattern).vertex).size(), 1U);
}

TEST(NestedDissection, VerticesFollowTheirPrincipalAxis) {
  constexpr int kVertices = 20;
  const BlockPattern path =
      test::PatternWhere(kVertices, [](int v, int w) { return std::abs(v - w) == 1; });
  Eigen::Matrix2Xd uv(2, kVertices);
  for (int v = 0; v < kVertices; ++v) uv.col(v) << 0.1 * (v % 2), 7 * v % kVertices;
  const auto nodes = NestedDissection(path, uv, {});
  ASSERT_EQ(nodes.size(), 1U);
  std::vector<double> place;
  for (const int v : nodes[0].vertices) place.push_back(uv(1, v));
  if (place.front() > place.back()) std::reverse(place.begin(), place.end());
  EXPECT_TRUE(std::is_sorted(place.begin(), place.end()));
}

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
