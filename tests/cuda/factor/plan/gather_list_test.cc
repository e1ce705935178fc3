// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <utility>

#include "cuda/factor/plan/front_plan.h"
#include "tests/cuda/factor/plan/plan_fixture.h"

namespace drape {
namespace {

Contribution Unpack(int item) { return {item >> 5, (item >> 4 & 1) == 1, item >> 2 & 3, item & 3}; }

// Random numbers in place of the elements' matrices, and of which kinds a scene has some.
class GatherListTest : public testing::TestWithParam<std::pair<bool, bool>> {
 protected:
  GatherListTest() {
    scene_.stretch = GetParam().first;
    scene_.bend = GetParam().second;
    const Mesh mesh = test::Disc(300);
    const BlockPattern pattern = MakeBlockPattern(mesh, scene_.stretch, scene_.bend);
    plan_ = MakeFrontPlan(pattern, mesh.uv, {});
    mesh_ = Renumber(mesh, plan_);
    pattern_ = MakeBlockPattern(mesh_, scene_.stretch, scene_.bend);
    std::mt19937_64 random(9);
    for (int k = 0; k < 9 * mesh_.num_faces(); ++k) face_.push_back(SampleNormal(random));
    for (int k = 0; k < 16 * mesh_.num_hinges(); ++k) hinge_.push_back(SampleNormal(random));
  }

  double Value(const Contribution& c) const {
    return c.hinge ? hinge_[16 * c.element + 4 * c.row + c.column]
                   : face_[9 * c.element + 3 * c.row + c.column];
  }
  double Sum(const GatherList& list, int target) const {
    double sum = 0;
    for (int k = list.start[target]; k < list.start[target + 1]; ++k)
      sum += Value(Unpack(list.item[k]));
    return sum;
  }
  // By the pattern's own lists.
  std::vector<double> AssembledBlocks() const {
    std::vector<double> sum(pattern_.num_blocks());
    for (std::size_t k = 0; k < pattern_.face_block.size(); ++k)
      sum[pattern_.face_block[k]] += face_[k];
    for (std::size_t k = 0; k < pattern_.hinge_block.size(); ++k)
      sum[pattern_.hinge_block[k]] += hinge_[k];
    return sum;
  }

  Scene scene_;
  FrontPlan plan_;
  Mesh mesh_;
  BlockPattern pattern_;
  std::vector<double> face_, hinge_;
};
INSTANTIATE_TEST_SUITE_P(StretchAndBend, GatherListTest,
                         testing::Values(std::pair(true, true), std::pair(true, false),
                                         std::pair(false, true), std::pair(false, false)));

TEST_P(GatherListTest, EntriesSumToTheAssembledMatrix) {
  const GatherList list = GatherEntries(plan_, mesh_, scene_);
  const std::vector<double> expected = AssembledBlocks();
  ASSERT_EQ(list.start.size(), plan_.entries.size() + 1);
  for (std::size_t e = 0; e < plan_.entries.size(); ++e) {
    const auto [row, column] = std::pair(plan_.entries[e].row, plan_.entries[e].column);
    const auto begin = pattern_.column.begin() + pattern_.row_start[row];
    const auto block = std::find(begin, pattern_.column.end(), column) - pattern_.column.begin();
    EXPECT_EQ(Sum(list, static_cast<int>(e)), expected[block]);
  }
}

TEST_P(GatherListTest, VerticesSumToTheAssembledVector) {
  const GatherList list = GatherVertices(mesh_, scene_);
  std::vector<double> expected(mesh_.num_vertices());
  for (int f = 0; scene_.stretch && f < mesh_.num_faces(); ++f)
    for (int k = 0; k < 3; ++k) expected[mesh_.faces[f].vertex[k]] += face_[9 * f + 4 * k];
  for (int e = 0; scene_.bend && e < mesh_.num_hinges(); ++e)
    for (int k = 0; k < 4; ++k) expected[mesh_.hinges[e].vertex[k]] += hinge_[16 * e + 5 * k];
  ASSERT_EQ(list.start.size(), expected.size() + 1);
  for (int v = 0; v < mesh_.num_vertices(); ++v) EXPECT_EQ(Sum(list, v), expected[v]);
}

TEST_P(GatherListTest, DiagonalEntriesAreOfAVertexWithItself) {
  const std::vector<int> diagonal = DiagonalEntries(plan_);
  ASSERT_EQ(static_cast<int>(diagonal.size()), mesh_.num_vertices());
  for (int i = 0; i < mesh_.num_vertices(); ++i) {
    EXPECT_EQ(plan_.entries[diagonal[i]].row, i);
    EXPECT_EQ(plan_.entries[diagonal[i]].column, i);
  }
}

TEST_P(GatherListTest, FacesComeFirstEachKindAscending) {
  for (const GatherList& list :
       {GatherEntries(plan_, mesh_, scene_), GatherVertices(mesh_, scene_)})
    for (std::size_t target = 0; target + 1 < list.start.size(); ++target)
      for (int k = list.start[target] + 1; k < list.start[target + 1]; ++k) {
        const Contribution a = Unpack(list.item[k - 1]), b = Unpack(list.item[k]);
        EXPECT_LT(std::pair(a.hinge, a.element), std::pair(b.hinge, b.element));
      }
}

TEST_P(GatherListTest, OrderByWorkFallsWithinEachChunk) {
  constexpr int kChunk = 128;
  const GatherList list = GatherEntries(plan_, mesh_, scene_);
  const std::vector<int> order = OrderByWork(list, kChunk);
  const auto work = [&](int target) { return list.start[target + 1] - list.start[target]; };
  const int count = static_cast<int>(plan_.entries.size());
  ASSERT_EQ(order.size(), plan_.entries.size());
  ASSERT_NE(count % kChunk, 0) << "the last chunk is not full";
  std::vector<int> seen(count);
  for (int i = 0; i < count; ++i) {
    EXPECT_EQ(order[i] / kChunk, i / kChunk);
    ++seen[order[i]];
    if (i % kChunk != 0) {
      EXPECT_GE(work(order[i - 1]), work(order[i]));
    }
  }
  EXPECT_THAT(seen, testing::Each(1));
}

TEST(Contribution, PackKeepsAllParts) {
  const Contribution c = Unpack(Contribution{1234567, true, 2, 3}.Pack());
  EXPECT_EQ(c.element, 1234567);
  EXPECT_TRUE(c.hinge);
  EXPECT_EQ(c.row, 2);
  EXPECT_EQ(c.column, 3);
}

TEST(GatherListDeathTest, PlanOfAnotherPattern) {
  const Mesh mesh = test::Disc(150);
  const FrontPlan plan = MakeFrontPlan(MakeBlockPattern(mesh, true, false), mesh.uv, {});
  EXPECT_DEATH(GatherEntries(plan, Renumber(mesh, plan), Scene{}), "pattern lacks block");
}

}  // namespace
}  // namespace drape
