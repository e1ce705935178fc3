// SPDX-License-Identifier: Apache-2.0
#include "cuda/front_plan.h"

#include <gmock/gmock.h>

#include <chrono>

#include "cuda/host_multifrontal.h"
#include "physics/assembly.h"
#include "physics/cloth_fixture.h"
#include "physics/errors.h"
#include "physics/linear_solver.h"
#include "physics/strip.h"

namespace drape {
namespace {

std::shared_ptr<const ClothModel> Cloth(const Mesh& mesh, bool bend = true) {
  Scene scene = CusickScene();
  scene.bend = bend;
  return std::make_shared<ClothModel>(mesh, scene, MakeLaw("smooth"));
}

Mesh Disc(int vertices) {
  DiscOptions options;
  options.target_vertices = vertices;
  return MakeDisc(options);
}

FrontPlan Plan(const ClothModel& model, const FrontPlanOptions& options = {}) {
  return MakeFrontPlan(model.pattern, model.mesh.uv, options);
}

void ExpectSolvesAsCholmod(const ClothModel& model, const FrontPlanOptions& options = {}) {
  std::mt19937_64 random(5);
  BlockMatrix A(model.pattern);
  Eigen::VectorXd force, x;
  AssembleStep(model, test::TestMaterial(), test::NoisyStart(model, 1e-3, random).x, 0.05, force,
               A);
  const Eigen::VectorXd b = test::RandomMatrix(model.num_dofs(), 1, random);
  Eigen::VectorXd expected = b;
  const auto solver = MakeCholmodSolver(model.pattern);
  ASSERT_TRUE(solver->Factor(A));
  solver->Solve(expected);

  const FrontPlan plan = Plan(model, options);
  test::HostMultifrontal host(plan);
  ASSERT_TRUE(host.Solve(test::EntryValues(plan, model.pattern, A), test::Permuted(plan, b), x));
  EXPECT_LT((test::Unpermuted(plan, x) - expected).norm(), 1e-10 * expected.norm());
}

class FrontPlanSolve : public testing::TestWithParam<bool> {};

TEST_P(FrontPlanSolve, Discs) {
  for (const int vertices : {150, 300, 1200}) {
    SCOPED_TRACE(vertices);
    ExpectSolvesAsCholmod(*Cloth(Disc(vertices), GetParam()));
  }
}

TEST_P(FrontPlanSolve, Strips) {
  ExpectSolvesAsCholmod(*Cloth(MakeStrip(0.3, 0.02, 90, 7), GetParam()));
  ExpectSolvesAsCholmod(*Cloth(MakeStrip(0.3, 0.01, 40, 1), GetParam()));
}
INSTANTIATE_TEST_SUITE_P(WithAndWithoutHinges, FrontPlanSolve, testing::Bool());

TEST(FrontPlan, Times) {
  for (const int vertices : {150, 300, 1200, 2700, 7500}) {
    const auto model = Cloth(Disc(vertices));
    const auto start = std::chrono::steady_clock::now();
    const FrontPlan plan = Plan(*model);
    std::printf("%d: %.2f MB, update %.2f MB, %zu fronts, %d levels, %.1f Mflop, %.3f s\n",
                vertices, plan.factor_size * 8e-6, plan.update_size * 8e-6, plan.fronts.size(),
                plan.num_levels(), plan.flops * 1e-6,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
}

}  // namespace
}  // namespace drape
