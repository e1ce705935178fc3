// SPDX-License-Identifier: Apache-2.0
// Tests of what a rollout returns besides its derivatives: recordings, statuses, cancellation.
#include "physics/simulation/rollout.h"

#include <gmock/gmock.h>

#include <limits>

#include "physics/cloth/assembly/assembly.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

TEST(RolloutTest, OneStepSolvesTheImplicitEquation) {
  std::mt19937_64 random(1);
  const auto model = test::SmallDisc("smooth");
  const MaterialField material = test::TestMaterial();
  State start = test::NoisyStart(*model, 1e-3, random);
  start.v = 0.1 * test::RandomMatrix(model->num_dofs(), 1, random);
  StepSolver solver(model);
  RolloutOptions options;
  options.steps = 1;
  const State end = Rollout(solver, material, start, options).end;
  // (M + h²H)·v' = M·v + h·f at the start, x' = x + h·v'.
  Eigen::VectorXd force;
  BlockMatrix A(model->pattern);
  AssembleStep(*model, material, start.x, options.h, force, A);
  RowMatrix product = RowMatrix::Zero(model->num_dofs(), 1);
  AddMultiply(model->pattern, A, end.v, product);
  const Eigen::VectorXd right =
      model->LumpedMass(material.density).cwiseProduct(start.v) + options.h * force;
  EXPECT_LT((product - right).norm(), 1e-11 * right.norm());
  EXPECT_LT((end.x - start.x - options.h * end.v).norm(), 1e-15 * end.x.norm());
}

TEST(RolloutTest, RecordingHoldsAllStatesAndTheLastFactorsThatFit) {
  const auto model = test::SmallDisc("smooth");
  StepSolver solver(model);
  RolloutOptions options;
  options.steps = 6;
  options.factor_memory = 2 * solver.linear().factor_bytes() + 8;
  Recording recording;
  const RolloutResult result =
      Rollout(solver, test::TestMaterial(), model->RestState(), options, &recording);
  EXPECT_EQ(result.steps, 6);
  ASSERT_EQ(recording.x.size(), 7u);
  ASSERT_EQ(recording.v.size(), 7u);
  ASSERT_EQ(recording.factor.size(), 6u);
  EXPECT_EQ(recording.x.front(), model->mesh.rest_x);
  EXPECT_EQ(recording.x.back(), result.end.x);
  for (int k = 0; k < 6; ++k) EXPECT_EQ(recording.factor[k].empty(), k < 4) << k;
}

TEST(RolloutTest, ContinuesWhereItStopped) {
  const auto model = test::SmallDisc("smooth");
  StepSolver solver(model);
  RolloutOptions all, half;
  all.steps = 8;
  half.steps = 4;
  const State once = Rollout(solver, test::TestMaterial(), model->RestState(), all).end;
  State twice = Rollout(solver, test::TestMaterial(), model->RestState(), half).end;
  twice = Rollout(solver, test::TestMaterial(), twice, half).end;
  EXPECT_EQ(once.x, twice.x);
  EXPECT_EQ(once.v, twice.v);
}

TEST(RolloutTest, NegativeStiffnessIsReportedAsStatus) {
  const auto model = test::SmallDisc("smooth");
  StepSolver solver(model);
  RolloutOptions options;
  options.steps = 3;
  const RolloutResult result =
      Rollout(solver, test::TestMaterial(-1e6), model->RestState(), options);
  EXPECT_EQ(result.status, RolloutStatus::kNotPositiveDefinite) << ToString(result.status);
  EXPECT_EQ(result.steps, 0);
}

TEST(RolloutTest, NanIsReportedAsStatus) {
  const auto model = test::SmallDisc("smooth");
  StepSolver solver(model);
  State start = model->RestState();
  start.v[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Rollout(solver, test::TestMaterial(), start, {}).status, RolloutStatus::kNotFinite);
}

TEST(RolloutTest, CancelEndsItAtOnce) {
  const auto model = test::SmallDisc("smooth");
  StepSolver solver(model);
  const std::atomic<bool> cancel = true;
  RolloutOptions options;
  options.cancel = &cancel;
  const State start = model->RestState();
  EXPECT_EQ(Rollout(solver, test::TestMaterial(), start, options).status,
            RolloutStatus::kCancelled);
  EXPECT_EQ(RolloutTangent(solver, test::TestMaterial(), test::TestMaterial(), start, options)
                .rollout.status,
            RolloutStatus::kCancelled);
}

TEST(RolloutDeathTest, OptionsAreChecked) {
  RolloutOptions options;
  options.h = 0.0;
  EXPECT_DEATH(options.Check(), "RolloutOptions::h");
}

// A term that a scene does not list has no pattern entry.
TEST(ClothModelTest, SceneWithoutBendHasASmallerPattern) {
  const Mesh mesh = test::SmallDisc("smooth")->mesh;
  Scene stretch_only = CusickScene();
  stretch_only.bend = false;
  const ClothModel full(mesh, CusickScene(), MakeLaw("smooth"));
  const ClothModel part(mesh, stretch_only, MakeLaw("smooth"));
  EXPECT_LT(part.pattern.num_blocks(), full.pattern.num_blocks());
  EXPECT_TRUE(part.pattern.hinge_block.empty());
  EXPECT_GT(full.held.size(), 10u);
}

TEST(EnergyTest, ForceOfGravityHandlesAndBendIsItsNegativeGradient) {
  std::mt19937_64 random(3);
  for (const std::string law : {"smooth", "reference"}) {
    Scene scene = CusickScene();
    scene.stretch = false;
    const ClothModel model(test::SmallDisc(law)->mesh, scene, MakeLaw(law));
    const Eigen::VectorXd x = test::NoisyStart(model, 2e-3, random).x;
    const Eigen::VectorXd direction = test::RandomMatrix(model.num_dofs(), 1, random);
    Eigen::VectorXd force;
    AssembleForce(model, test::TestMaterial(), x, force);
    const double exact = -force.dot(direction);
    double best = 1.0;
    for (double step = 1e-5; step > 1e-9; step /= 10)
      best = std::min(best, std::fabs((Energy(model, test::TestMaterial(), x + step * direction) -
                                       Energy(model, test::TestMaterial(), x - step * direction)) /
                                          (2 * step) / exact -
                                      1.0));
    EXPECT_LT(best, 1e-7) << law;
  }
}

}  // namespace
}  // namespace drape
