// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/nested_dissection.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

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

}  // namespace
}  // namespace drape
