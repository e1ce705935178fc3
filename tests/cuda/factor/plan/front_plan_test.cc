// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/plan/front_plan.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <functional>

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

}  // namespace
}  // namespace drape
