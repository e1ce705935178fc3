// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "physics/cloth/assembly/assembly.h"
#include "physics/linalg/linear_solver.h"
#include "physics/linalg/symbolic_analysis.h"
#include "physics/mesh/mesh_spec.h"
#include "tests/cuda/factor/plan/host_multifrontal.h"
#include "tests/cuda/factor/plan/plan_fixture.h"

namespace drape {
namespace {

BlockMatrix MakeStepMatrix(const ClothModel& model, std::mt19937_64& random) {
  BlockMatrix A(model.pattern);
  Eigen::VectorXd force;
  AssembleStep(model, test::TestMaterial(), test::NoisyStart(model, 1e-3, random).x, 0.05, force,
               A);
  return A;
}

// Symmetric, diagonally dominant.
BlockMatrix RandomMatrixOn(const BlockPattern& pattern, std::mt19937_64& random) {
  BlockMatrix A(pattern);
  for (int v = 0; v < pattern.num_vertices(); ++v)
    for (int b = pattern.row_start[v]; b < pattern.row_start[v + 1]; ++b) {
      const int w = pattern.column[b];
      if (w == v) A.AddScaledIdentity(b, 3.0 * pattern.num_vertices());
      if (w >= v) continue;
      const auto row = pattern.column.begin() + pattern.row_start[w];
      const auto mirror = std::find(row, pattern.column.end(), v) - pattern.column.begin();
      for (int k = 0; k < 9; ++k)
        A.block(b)[k] = A.block(mirror)[k % 3 * 3 + k / 3] = SampleUniform(random);
    }
  return A;
}

Eigen::VectorXd SolveByPlan(const FrontPlan& plan, const BlockPattern& pattern,
                            const BlockMatrix& A, const Eigen::VectorXd& b) {
  test::HostMultifrontal host(plan);
  Eigen::VectorXd x;
  EXPECT_TRUE(host.Solve(test::EntryValues(plan, pattern, A), test::Permuted(plan, b), x));
  return test::Unpermuted(plan, x);
}

void ExpectSolvesAsTheHost(const FrontPlan& plan, const BlockPattern& pattern,
                           const BlockMatrix& A) {
  std::mt19937_64 random(6);
  const Eigen::VectorXd b = test::RandomMatrix(3 * pattern.num_vertices(), 1, random);
  Eigen::VectorXd expected = b;
  const auto solver = MakeLinearSolver(pattern);
  ASSERT_TRUE(solver->Factor(A));
  solver->Solve(expected);
  const Eigen::VectorXd x = SolveByPlan(plan, pattern, A, b);
  EXPECT_LT((x - expected).norm(), 1e-11 * expected.norm());
}
void ExpectSolvesAsTheHost(const BlockPattern& pattern, const Eigen::Matrix2Xd& uv,
                           const BlockMatrix& A, const FrontPlanOptions& options = {}) {
  ExpectSolvesAsTheHost(MakeFrontPlan(pattern, uv, options), pattern, A);
}

// By the fronts of the host's order of elimination.
void ExpectSolvesInOrder(const BlockPattern& pattern, const EliminationOrder& order,
                         const BlockMatrix& A) {
  ExpectSolvesAsTheHost(MakeFrontPlan(pattern, MakeSeparators(pattern, order.vertex), {}), pattern,
                        A);
}

TEST(FrontPlanSolve, InTheOrderOfTheHostAndWithBlocksOfContact) {
  std::mt19937_64 random(8);
  for (const int vertices : {150, 900}) {
    const auto model = test::Cloth(test::Disc(vertices), true, true);
    const EliminationOrder order = DissectVertices(model->pattern);
    ExpectSolvesInOrder(model->pattern, order, MakeStepMatrix(*model, random));
    for (const int groups : {2, 40}) {
      std::vector<std::array<int, 4>> more;
      const int n = model->mesh.num_vertices();
      for (int k = 0; k < groups; ++k) more.push_back({k, n / 3 + k, n / 2 + k, n - 1 - k});
      const BlockPattern touching = AddGroups(model->pattern, more);
      ExpectSolvesInOrder(touching, AdaptOrder(order, model->pattern, touching),
                          RandomMatrixOn(touching, random));
    }
  }
}

void ExpectSolves(const Mesh& mesh, bool stretch, bool bend, const FrontPlanOptions& options = {}) {
  SCOPED_TRACE(mesh.num_vertices());
  std::mt19937_64 random(5);
  const auto model = test::Cloth(mesh, stretch, bend);
  ExpectSolvesAsTheHost(model->pattern, mesh.uv, MakeStepMatrix(*model, random), options);
}

class FrontPlanSolve : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(WithAndWithoutHinges, FrontPlanSolve, testing::Bool());

TEST_P(FrontPlanSolve, Discs) {
  for (const int vertices : {150, 300, 1200}) ExpectSolves(test::Disc(vertices), true, GetParam());
}

TEST_P(FrontPlanSolve, Strips) {
  ExpectSolves(MakeStrip(0.3, 0.02, 90, 7), true, GetParam());
  ExpectSolves(MakeStrip(0.3, 0.01, 40, 1), true, GetParam());
}

TEST_P(FrontPlanSolve, OneFront) { ExpectSolves(test::TwoFaces(), true, GetParam()); }

TEST(FrontPlanSolve, HingesAlone) { ExpectSolves(test::Disc(300), false, true); }

TEST(FrontPlanSolve, OtherLimits) {
  for (const int max_pivots : {3, 16, 64})
    for (const int shared_bytes : {48 * 1024, 232448})
      for (const int leaf_vertices : {1, 60}) {
        const FrontPlanOptions options{{leaf_vertices}, max_pivots, shared_bytes};
        ExpectSolves(test::Disc(300), true, true, options);
      }
}

TEST(FrontPlanSolve, PatternsThatAreNoMeshs) {
  std::mt19937_64 random(5);
  for (const auto& [pattern, uv] : {test::TwoDiscs(200), test::Isolated(60), test::Complete(60)})
    ExpectSolvesAsTheHost(pattern, uv, RandomMatrixOn(pattern, random));
}

TEST(FrontPlanSolve, NotPositiveDefiniteIsFalse) {
  std::mt19937_64 random(5);
  const auto model = test::Cloth(test::Disc(150), true, true);
  BlockMatrix A = MakeStepMatrix(*model, random);
  A.AddScaledIdentity(model->pattern.diagonal[40], -1e3);
  const FrontPlan plan = MakeFrontPlan(model->pattern, model->mesh.uv, {});
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(model->num_dofs());
  Eigen::VectorXd x;
  test::HostMultifrontal host(plan);
  EXPECT_FALSE(host.Solve(test::EntryValues(plan, model->pattern, A), b, x));
}

}  // namespace
}  // namespace drape
