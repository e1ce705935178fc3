// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "physics/material/material_scaling.h"
#include "physics/simulation/statics/statics.h"
#include "solver/fit/outline_residuals.h"
#include "solver/fit/protocol/initial_guess.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

// On bend: some folds, as of a fabric.
constexpr double kSoft = 0.1;

class GuidedDrapeTest : public testing::Test {
 protected:
  GuidedDrapeTest() {
    settle_.steps = {.h = 0.1, .steps = 60};
    settle_.equilibrium.max_iterations = 60;
  }
  // A drape of the material as an image has it.
  Observation Observe(const State& start) {
    const State drape = test::Settled(*backend_, material_, start);
    return test::MakeObservation(backend_->model().mesh, drape, 90, "reference");
  }
  double Rms(const SettledDrape& drape, const Observation& observation) const {
    return OutlineRms(backend_->model().mesh, drape.rest.x, observation).value();
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(200);
  const MaterialField material_ = Scaled(test::TestMaterial(), 1.0, kSoft);
  SettleOptions settle_;
};

// The hem goes as far as the outline is away, along its normal; the support stays, and between
// them the cloth goes in proportion.
TEST_F(GuidedDrapeTest, ThePullIsTheDistanceToTheOutline) {
  const ClothModel& model = backend_->model();
  const Eigen::VectorXd flat = model.RestState().x;
  Observation observation = test::MakeObservation(model.mesh, model.RestState(), 360, "flat");
  const OutlinePull none(model, observation);  // but for the pixels of the image
  EXPECT_LT(none.Displacement(flat).cwiseAbs().maxCoeff(), 1e-4);
  constexpr double kFurther = 0.01;  // [m]
  observation.radius.array() += kFurther * observation.outline_camera().pixels_per_metre();
  const OutlinePull pull(model, observation);
  const Eigen::VectorXd displacement = pull.Displacement(flat);
  for (int v = 0; v < model.mesh.num_vertices(); ++v) {
    const Eigen::Vector2d p = model.mesh.uv.col(v);
    const double share =
        std::max(0.0, (p.norm() - DrapeDiscs().support) / (0.15 - DrapeDiscs().support));
    const Eigen::Vector3d d = displacement.segment<3>(3 * v);
    EXPECT_NEAR(d.head<2>().dot(p.normalized()), share * kFurther, 0.02 * kFurther) << v;
    EXPECT_NEAR(d.z(), 0.0, 1e-12);
  }
}

// From the start shapes of a fit it finds drapes that are nearer to the image than those that the
// same steps find without the pull. They are at rest, without any pull.
TEST_F(GuidedDrapeTest, FindsADrapeNearTheImage) {
  double guided_sum = 0.0, free_sum = 0.0;
  for (const int seed : {1, 2, 3, 4}) {
    const Observation observation = Observe(test::RandomStart(backend_->model(), seed, 2e-2));
    for (const double lift : {0.6, 0.8, 1.0}) {
      const State start = GuessState(backend_->model(), observation, lift);
      const SettledDrape guided = SettleGuided(*backend_, material_, start, observation, settle_);
      const SettledDrape free =
          std::move(Settle(*backend_, material_, {&start, 1}, settle_).front());
      ASSERT_TRUE(guided.IsUsable(settle_.solve_mode) && free.IsUsable(settle_.solve_mode));
      EXPECT_LT(ForceResidual(backend_->model(), material_, guided.rest.x), kAtRestResidual);
      guided_sum += Rms(guided, observation);
      free_sum += Rms(free, observation);
    }
  }
  std::printf("mean distance: guided %.2f px, free %.2f px\n", guided_sum / 12, free_sum / 12);
  EXPECT_LT(guided_sum, 0.97 * free_sum);
}

TEST_F(GuidedDrapeTest, AFailedStepIsAStatus) {
  std::atomic<bool> cancel = true;
  settle_.steps.cancel = &cancel;
  const Observation observation = Observe(test::RandomStart(backend_->model(), 1));
  const SettledDrape drape = SettleGuided(
      *backend_, material_, test::RandomStart(backend_->model(), 2), observation, settle_);
  EXPECT_EQ(drape.steps, RolloutStatus::kCancelled);
  EXPECT_FALSE(drape.IsUsable(settle_.solve_mode));
}

}  // namespace
}  // namespace drape
