// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/symbolic_analysis.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "physics/linalg/linear_solver.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// The pattern of a disc, and of the same disc with blocks between groups of vertices that are not
// neighbours, as contact makes them.
class EliminationOrderTest : public testing::Test {
 protected:
  BlockPattern Touching(int groups) {
    std::uniform_int_distribution<int> vertex(0, mesh_.num_vertices() - 1);
    std::vector<std::array<int, 4>> more;
    for (int k = 0; k < groups; ++k)
      more.push_back({vertex(random_), vertex(random_), vertex(random_), vertex(random_)});
    return AddGroups(pattern_, more);
  }
  static void ExpectPostorder(const EliminationOrder& order, const BlockPattern& pattern) {
    std::vector<int> sorted = order.vertex;
    std::sort(sorted.begin(), sorted.end());
    for (int i = 0; i < pattern.num_vertices(); ++i) ASSERT_EQ(sorted[i], i);
    // A node follows its last child at once.
    const std::vector<int> parent = EliminationTree(pattern, order.vertex);
    std::vector<bool> has_children(parent.size() + 1, false);
    for (std::size_t k = 0; k < parent.size(); ++k) {
      ASSERT_GT(parent[k], static_cast<int>(k));
      if (has_children[k]) {
        EXPECT_EQ(parent[k - 1], static_cast<int>(k));
      }
      has_children[parent[k]] = true;
    }
  }

  std::mt19937_64 random_{3};
  const Mesh mesh_ = test::SmallDisc("smooth", 900)->mesh;
  const BlockPattern pattern_ = MakeBlockPattern(mesh_, true, true);
};

TEST_F(EliminationOrderTest, GroupsAddTheirBlocksAndKeepTheOthers) {
  const std::vector<std::array<int, 4>> groups = {{0, 400, 5, 400}, {7, 7, 7, 7}, {899, 1, 0, 300}};
  const BlockPattern wider = AddGroups(pattern_, groups);
  std::set<std::pair<int, int>> expected;
  for (int i = 0; i < pattern_.num_vertices(); ++i)
    for (int b = pattern_.row_start[i]; b < pattern_.row_start[i + 1]; ++b)
      expected.emplace(i, pattern_.column[b]);
  const auto own = expected.size();
  for (const auto& group : groups)
    for (const int i : group)
      for (const int j : group) expected.emplace(i, j);
  EXPECT_GT(expected.size(), own);
  std::set<std::pair<int, int>> found;
  for (int i = 0; i < wider.num_vertices(); ++i)
    for (int b = wider.row_start[i]; b < wider.row_start[i + 1]; ++b) {
      found.emplace(i, wider.column[b]);
      EXPECT_EQ(wider.Find(i, wider.column[b]), b);
    }
  EXPECT_EQ(found, expected);
  for (const auto& group : groups) EXPECT_TRUE(wider.HasAllBlocks(group));
  EXPECT_FALSE(pattern_.HasAllBlocks(groups[0]));
  for (int i = 0; i < wider.num_vertices(); ++i) EXPECT_EQ(wider.diagonal[i], wider.Find(i, i));
  for (int f = 0; f < mesh_.num_faces(); ++f)
    for (int k = 0; k < 9; ++k)
      EXPECT_EQ(wider.face_block[9 * f + k],
                wider.Find(mesh_.faces[f].vertex[k / 3], mesh_.faces[f].vertex[k % 3]));
  for (int e = 0; e < mesh_.num_hinges(); ++e)
    for (int k = 0; k < 16; ++k)
      EXPECT_EQ(wider.hinge_block[16 * e + k],
                wider.Find(mesh_.hinges[e].vertex[k / 4], mesh_.hinges[e].vertex[k % 4]));
}

// A path a – b – c, eliminated from both ends: b is the parent of the others.
TEST(EliminationTreeTest, PathFromBothEnds) {
  BlockPattern path;
  path.row_start = {0, 2, 5, 7};
  path.column = {0, 1, 0, 1, 2, 1, 2};
  EXPECT_THAT(EliminationTree(path, {0, 2, 1}), testing::ElementsAre(2, 2, 3));
  EXPECT_THAT(EliminationTree(path, {0, 1, 2}), testing::ElementsAre(1, 2, 3));
  EXPECT_THAT(EliminationTree(path, {1, 0, 2}), testing::ElementsAre(1, 2, 3));  // with fill
}

TEST_F(EliminationOrderTest, DissectionIsAPostorder) {
  ExpectPostorder(DissectVertices(pattern_), pattern_);
}

TEST_F(EliminationOrderTest, FewNewBlocksTakeHardlyMoreOperationsThanANewDissection) {
  const EliminationOrder order = DissectVertices(pattern_);
  const BlockPattern touching = Touching(2);
  const EliminationOrder adapted = AdaptOrder(order, pattern_, touching),
                         dissected = DissectVertices(touching);
  ExpectPostorder(adapted, touching);
  EXPECT_NE(adapted.vertex, dissected.vertex);
  EXPECT_LE(adapted.operations, 1.25 * order.dissected_operations);
  EXPECT_EQ(adapted.dissected_operations, order.dissected_operations);
  EXPECT_LT(adapted.operations, 1.3 * dissected.operations);
  // Without moving vertices it takes more: as the order was, the parts of the cloth become one.
  const EliminationOrder kept{order.vertex, order.operations, 1e30};
  const BlockPattern none = MakeBlockPattern(mesh_, false, false);
  EXPECT_EQ(AdaptOrder(kept, pattern_, pattern_).vertex, order.vertex);
  EXPECT_NE(AdaptOrder(kept, pattern_, touching).vertex, order.vertex);
  EXPECT_LE(AdaptOrder(order, pattern_, none).operations, order.operations);
}

TEST_F(EliminationOrderTest, ManyNewBlocksAreDissectedAnew) {
  const BlockPattern touching = Touching(300);
  const EliminationOrder adapted = AdaptOrder(DissectVertices(pattern_), pattern_, touching),
                         dissected = DissectVertices(touching);
  EXPECT_EQ(adapted.vertex, dissected.vertex);
  EXPECT_EQ(adapted.dissected_operations, dissected.operations);
}

TEST_F(EliminationOrderTest, AdaptedSolversSolve) {
  const auto own = MakeLinearSolver(pattern_);
  for (const int groups : {0, 2, 10, 300}) {
    const BlockPattern touching = Touching(groups);
    BlockMatrix A(touching);
    for (int i = 0; i < touching.num_vertices(); ++i)
      for (int b = touching.row_start[i]; b < touching.row_start[i + 1]; ++b)
        A.AddScaledIdentity(b, touching.column[b] == i ? 3.0 * touching.num_vertices() : -1.0);
    const auto solver = own->Adapt(touching);
    ASSERT_TRUE(solver->Factor(A));
    const RowMatrix b = test::RandomMatrix(3 * touching.num_vertices(), 3, random_);
    RowMatrix x = b, product = RowMatrix::Zero(b.rows(), b.cols());
    solver->Solve(x);
    AddMultiply(touching, A, x, product);
    EXPECT_LT((product - b).norm(), 1e-12 * b.norm()) << groups << " groups";
  }
}

}  // namespace
}  // namespace drape
