// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/front_plan.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <random>
#include <utility>

#include "physics/mesh/mesh_spec.h"
#include "physics/util/errors.h"
#include "tests/cuda/factor/plan/plan_fixture.h"

namespace drape {
namespace {

using testing::Each;
using testing::ElementsAre;

// Patterns are made in their own test: ctest runs each in a process that registers all.
struct PlanCase {
  std::string name;
  std::function<test::PlacedPattern()> place;
  FrontPlanOptions options;
};
void PrintTo(const PlanCase& c, std::ostream* out) { *out << c.name; }

test::PlacedPattern Placed(const Mesh& mesh, bool hinges) {
  return {MakeBlockPattern(mesh, true, hinges), mesh.uv};
}
std::function<test::PlacedPattern()> PlacedDisc(int vertices, bool hinges = true) {
  return [=] { return Placed(test::Disc(vertices), hinges); };
}

std::vector<PlanCase> Cases() {
  return {{"disc", PlacedDisc(300), {}},
          {"large_disc", PlacedDisc(2000), {}},
          {"faces_alone", PlacedDisc(300, false), {}},
          {"strip", [] { return Placed(MakeStrip(0.3, 0.02, 90, 7), true); }, {}},
          {"two_discs", [] { return test::TwoDiscs(200); }, {}},
          {"isolated", [] { return test::Isolated(60); }, {}},
          {"complete", [] { return test::Complete(60); }, {}},
          {"one_front", [] { return Placed(test::TwoFaces(), true); }, {}},
          {"no_vertex",
           [] {
             return test::PlacedPattern{test::BlockPatternFrom({}), Eigen::Matrix2Xd(2, 0)};
           },
           {}},
          {"little_memory", PlacedDisc(1200), {{}, 63, 48 * 1024}},
          {"small_fronts", PlacedDisc(300), {{1}, 3, 232448}}};
}

// Elimination-order dof of each row of a front, −1 in the padding.
std::vector<int> RowDofs(const FrontPlan& plan, const Front& f) {
  std::vector<int> dof(f.pivots, -1);
  for (int r = 0; r < f.true_pivots; ++r) dof[r] = f.first_dof + r;
  const auto border = plan.border_dof.begin() + f.border_start;
  dof.insert(dof.end(), border, border + f.border);
  return dof;
}

class FrontPlanTest : public testing::TestWithParam<PlanCase> {
 protected:
  FrontPlan MakePlan() const {
    return MakeFrontPlan(placed_.pattern, placed_.uv, GetParam().options);
  }

  const test::PlacedPattern placed_ = GetParam().place();
  const BlockPattern& pattern_ = placed_.pattern;
  const FrontPlan plan_ = MakePlan();
};
INSTANTIATE_TEST_SUITE_P(Patterns, FrontPlanTest, testing::ValuesIn(Cases()),
                         [](const auto& info) { return info.param.name; });

TEST_P(FrontPlanTest, EachVertexIsEliminatedOnce) {
  ASSERT_EQ(plan_.num_vertices(), pattern_.num_vertices());
  for (int v = 0; v < plan_.num_vertices(); ++v) EXPECT_EQ(plan_.vertex[plan_.position[v]], v);
  int dof = 0;
  for (const Front& f : plan_.fronts) {
    EXPECT_EQ(f.first_dof, dof);
    dof += f.true_pivots;
  }
  EXPECT_EQ(dof, 3 * plan_.num_vertices());
}

TEST_P(FrontPlanTest, FrontsKeepToTheLimits) {
  for (const Front& f : plan_.fronts) {
    EXPECT_EQ(f.pivots, (f.true_pivots + 7) / 8 * 8);
    EXPECT_EQ(f.border, (f.true_border + 7) / 8 * 8);
    EXPECT_GT(f.true_pivots, 0);
    EXPECT_LE(f.true_pivots, GetParam().options.max_pivots);
    EXPECT_LE(f.pivots, 64);
    EXPECT_LE(((f.pivots + f.border + 8) * (f.pivots + 4)) * 8, GetParam().options.shared_bytes);
  }
}

TEST_P(FrontPlanTest, EntriesAreTheLowerTriangle) {
  std::vector<std::pair<int, int>> expected, found;
  for (int v = 0; v < pattern_.num_vertices(); ++v)
    for (int b = pattern_.row_start[v]; b < pattern_.row_start[v + 1]; ++b) {
      const int row = plan_.position[pattern_.column[b]], column = plan_.position[v];
      if (row >= column) expected.emplace_back(column, row);
    }
  std::sort(expected.begin(), expected.end());
  int next = 0;
  for (const Front& f : plan_.fronts) {
    EXPECT_EQ(f.entry_start, next);
    const std::vector<int> dof = RowDofs(plan_, f);
    for (; next < f.entry_end; ++next) {
      const FrontEntry& e = plan_.entries[next];
      found.emplace_back(e.column, e.row);
      EXPECT_EQ(dof[e.panel_row], 3 * e.row);
      EXPECT_EQ(dof[e.panel_column], 3 * e.column);
      EXPECT_LT(e.panel_column, f.pivots);
    }
  }
  EXPECT_EQ(found, expected);
}

TEST_P(FrontPlanTest, ChildrenFindTheirRowsInTheParent) {
  std::vector<int> parents(plan_.fronts.size(), 0);
  int next = 0;
  for (std::size_t i = 0; i < plan_.fronts.size(); ++i) {
    const Front& f = plan_.fronts[i];
    EXPECT_EQ(f.child_start, next);
    const std::vector<int> parent_dof = RowDofs(plan_, f);
    for (; next < f.child_end; ++next) {
      const FrontChild& child = plan_.children[next];
      const Front& from = plan_.fronts[child.front];
      ++parents[child.front];
      EXPECT_LT(child.front, static_cast<int>(i));
      const auto* row = plan_.child_row.data() + child.row_start;
      int expected = 0;  // each row of the border once, in its order
      for (int r = 0; r < f.pivots + f.border; ++r) {
        if (row[r] < 0) continue;
        EXPECT_EQ(row[r], expected++);
        EXPECT_EQ(parent_dof[r], plan_.border_dof[from.border_start + row[r]]);
      }
      EXPECT_EQ(expected, from.true_border);
    }
  }
  EXPECT_EQ(next, static_cast<int>(plan_.children.size()));
  for (std::size_t i = 0; i < plan_.fronts.size(); ++i)
    EXPECT_EQ(parents[i], plan_.fronts[i].true_border > 0) << "only a root has no border";
}

TEST_P(FrontPlanTest, LevelsFollowTheTree) {
  std::vector<int> level(plan_.fronts.size(), -1);
  for (int l = 0; l < plan_.num_levels(); ++l)
    for (int k = plan_.level_start[l]; k < plan_.level_start[l + 1]; ++k) {
      const Front& f = plan_.fronts[plan_.level_front[k]];
      EXPECT_EQ(level[plan_.level_front[k]], -1);
      level[plan_.level_front[k]] = l;
      int highest = -1;
      for (int c = f.child_start; c < f.child_end; ++c) {
        EXPECT_GE(level[plan_.children[c].front], 0);
        highest = std::max(highest, level[plan_.children[c].front]);
      }
      EXPECT_EQ(l, highest + 1);
    }
  EXPECT_THAT(level, Each(testing::Ge(0)));
}

TEST_P(FrontPlanTest, OffsetsAreAlignedAndInside) {
  std::int64_t factor = 0, vector = 0;
  for (const Front& f : plan_.fronts) {
    const std::int64_t p = f.pivots, q = f.border;
    EXPECT_EQ(f.factor_offset, factor);
    EXPECT_EQ(f.vector_offset, vector);
    EXPECT_EQ(f.factor_offset % 2 + f.update_offset % 2, 0);
    EXPECT_LE(f.update_offset + (q + 1) * q, plan_.update_size);
    factor += (p + q) * p;
    vector += q;
  }
  EXPECT_EQ(plan_.factor_size, factor);
  EXPECT_EQ(plan_.vector_size, vector);
}

template <class T>
bool SameBytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

TEST_P(FrontPlanTest, IsTheSameEachTime) {
  const FrontPlan again = MakePlan();
  EXPECT_EQ(plan_.position, again.position);
  EXPECT_TRUE(SameBytes(plan_.fronts, again.fronts));
  EXPECT_TRUE(SameBytes(plan_.entries, again.entries));
  EXPECT_EQ(plan_.border_dof, again.border_dof);
  EXPECT_EQ(plan_.child_row, again.child_row);
  EXPECT_EQ(plan_.level_front, again.level_front);
}

TEST(FrontPlan, SmallMeshIsOneFront) {
  const Mesh mesh = test::TwoFaces();
  const FrontPlan plan = MakeFrontPlan(MakeBlockPattern(mesh, true, true), mesh.uv, {});
  ASSERT_EQ(plan.fronts.size(), 1U);
  EXPECT_EQ(plan.fronts[0].pivots, 16);
  EXPECT_EQ(plan.fronts[0].true_pivots, 12);
  EXPECT_EQ(plan.fronts[0].border, 0);
  EXPECT_EQ(plan.entries.size(), 10U);
  EXPECT_THAT(plan.level_start, ElementsAre(0, 1));
}

TEST(FrontPlan, SmallFrontsAreMerged) {
  const Mesh mesh = test::Disc(300);
  const BlockPattern pattern = MakeBlockPattern(mesh, true, true);
  const FrontPlanOptions options{{4}, 63, 232448};
  const auto separators = NestedDissection(pattern, mesh.uv, options.dissection);
  EXPECT_LT(MakeFrontPlan(pattern, mesh.uv, options).fronts.size(), 0.75 * separators.size());
}

TEST(FrontPlan, LargeFrontsComeFirstInALevel) {
  const Mesh mesh = test::Disc(1200);
  const FrontPlan plan = MakeFrontPlan(MakeBlockPattern(mesh, true, true), mesh.uv, {});
  const auto size = [&](int k) {
    const Front& f = plan.fronts[plan.level_front[k]];
    return (f.pivots + f.border) * f.pivots + f.border * f.border;
  };
  for (int l = 0; l < plan.num_levels(); ++l)
    for (int k = plan.level_start[l] + 1; k < plan.level_start[l + 1]; ++k)
      EXPECT_GE(size(k - 1), size(k));
}

// Sizes that a prototype in another language reached on meshes of about these sizes [MB].
TEST(FrontPlan, FactorsAreSmall) {
  const std::pair<int, double> expected[] = {{300, 0.90}, {1200, 5.0}, {2700, 12.8}};
  for (const auto& [vertices, megabytes] : expected) {
    const Mesh mesh = test::Disc(vertices);
    const FrontPlan plan = MakeFrontPlan(MakeBlockPattern(mesh, true, true), mesh.uv, {});
    EXPECT_NEAR(plan.factor_size * 8e-6, megabytes, 0.15 * megabytes) << vertices;
    EXPECT_LT(plan.update_size, plan.factor_size) << "space of updates is used again";
    EXPECT_GT(plan.flops, 8.0 * plan.factor_size);
  }
}

TEST(FrontPlan, PanelThatDoesNotFitIsAnInputError) {
  const Mesh mesh = test::Disc(300);
  const BlockPattern pattern = MakeBlockPattern(mesh, true, true);
  EXPECT_THROW(MakeFrontPlan(pattern, mesh.uv, {{}, 63, 8 * 1024}), InputError);
}

TEST(FrontPlanDeathTest, MaxPivotsBeyondATile) {
  const Mesh mesh = test::TwoFaces();
  const BlockPattern pattern = MakeBlockPattern(mesh, true, true);
  EXPECT_DEATH(MakeFrontPlan(pattern, mesh.uv, {{}, 65, 232448}), "max_pivots");
}

TEST(Renumber, ElementsKeepTheirPlaces) {
  const Mesh mesh = test::Disc(150);
  const FrontPlan plan = MakeFrontPlan(MakeBlockPattern(mesh, true, true), mesh.uv, {});
  const Mesh renumbered = Renumber(mesh, plan);
  const auto expect_same = [&](int before, int after) {
    EXPECT_EQ(after, plan.position[before]);
    EXPECT_EQ(mesh.uv.col(before), renumbered.uv.col(after));
    EXPECT_EQ(mesh.rest_x.segment<3>(3 * before), renumbered.rest_x.segment<3>(3 * after));
  };
  for (int f = 0; f < mesh.num_faces(); ++f)
    for (int k = 0; k < 3; ++k) expect_same(mesh.faces[f].vertex[k], renumbered.faces[f].vertex[k]);
  for (int e = 0; e < mesh.num_hinges(); ++e)
    for (int k = 0; k < 4; ++k)
      expect_same(mesh.hinges[e].vertex[k], renumbered.hinges[e].vertex[k]);
  ASSERT_EQ(mesh.boundary_loops.size(), renumbered.boundary_loops.size());
  for (std::size_t k = 0; k < mesh.boundary_loops[0].size(); ++k)
    expect_same(mesh.boundary_loops[0][k], renumbered.boundary_loops[0][k]);
}

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

TEST(PackUpdates, FirstFit) {
  // The last takes the gap of the second, too small for the fourth.
  const UpdateSpace space = PackUpdates({{10, 0, 3}, {8, 0, 1}, {4, 0, 3}, {9, 2, 3}, {6, 2, 3}});
  EXPECT_THAT(space.offset, ElementsAre(0, 10, 18, 22, 10));
  EXPECT_EQ(space.size, 31);
}

TEST(PackUpdates, LastLevelIsStillInUse) {
  EXPECT_EQ(PackUpdates({{10, 0, 1}, {10, 1, 2}}).size, 20);
  EXPECT_EQ(PackUpdates({{10, 0, 1}, {10, 2, 2}}).size, 10);
}

TEST(PackUpdates, NoTwoInUseOverlap) {
  std::mt19937_64 random(3);
  std::vector<UpdateBlock> blocks;
  for (int i = 0; i < 300; ++i) {
    const int first = static_cast<int>(random() % 20);
    blocks.push_back(
        {static_cast<std::int64_t>(random() % 90), first, first + static_cast<int>(random() % 5)});
  }
  const UpdateSpace space = PackUpdates(blocks);
  for (std::size_t a = 0; a < blocks.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_TRUE(blocks[a].last < blocks[b].first || blocks[b].last < blocks[a].first ||
                  space.offset[a] + blocks[a].size <= space.offset[b] ||
                  space.offset[b] + blocks[b].size <= space.offset[a]);
}

TEST(PackUpdates, Nothing) { EXPECT_EQ(PackUpdates({}).size, 0); }

}  // namespace
}  // namespace drape
