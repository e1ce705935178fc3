// SPDX-License-Identifier: Apache-2.0
#include "physics/backend.h"

#include <gmock/gmock.h>

#include <limits>

#include "cloth_fixture.h"

namespace drape {
namespace {

class BackendTest : public testing::Test {
 protected:
  static constexpr int kBatch = 5;
  BackendTest() {
    for (int i = 0; i < kBatch; ++i) {
      materials_.push_back(i % 2 == 0
                               ? test::TestMaterial(1.0 + 0.3 * i)
                               : test::Scatter(test::TestMaterial(), model_->mesh, 0.3, random_));
      starts_.push_back(test::NoisyStart(*model_, 1e-3, random_));
      seeds_.push_back(test::RandomMatrix(model_->num_dofs(), i % 2 + 1, random_));
    }
    options_.steps = 5;
  }
  std::vector<RolloutInput> Inputs() const {
    std::vector<RolloutInput> inputs;
    for (int i = 0; i < kBatch; ++i) inputs.push_back({&materials_[i], &starts_[i]});
    return inputs;
  }

  std::mt19937_64 random_{23};
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth");
  std::vector<MaterialField> materials_;
  std::vector<State> starts_;
  std::vector<RowMatrix> seeds_;
  RolloutOptions options_;
};

TEST_F(BackendTest, BatchIsEqualToOneByOneBitForBit) {
  const auto backend = MakeCpuBackend(model_, 3);
  EXPECT_EQ(backend->name(), "cpu");
  EXPECT_EQ(&backend->model(), model_.get());
  std::vector<const MaterialField*> weights;
  for (const MaterialField& material : materials_) weights.push_back(&material);
  std::vector<Recording> recordings;
  const auto rollouts = backend->Rollouts(Inputs(), options_, &recordings);
  const auto tangents = backend->Tangents(Inputs(), weights, options_);
  const auto adjoints = backend->Adjoints(Inputs(), recordings, seeds_, options_);
  ASSERT_EQ(rollouts.size(), kBatch);
  StepSolver solver(model_);
  for (int i = 0; i < kBatch; ++i) {
    Recording recording;
    const auto rollout = Rollout(solver, materials_[i], starts_[i], options_, &recording);
    const auto tangent = RolloutTangent(solver, materials_[i], materials_[i], starts_[i], options_);
    const auto adjoint = RolloutAdjoint(solver, materials_[i], options_, recording, seeds_[i]);
    EXPECT_EQ(rollouts[i].end.x, rollout.end.x) << i;
    EXPECT_EQ(recordings[i].x.back(), rollout.end.x) << i;
    EXPECT_EQ(tangents[i].dx, tangent.dx) << i;
    EXPECT_EQ(adjoints[i].material.stretch, adjoint.material.stretch) << i;
    EXPECT_EQ(adjoints[i].material.bend, adjoint.material.bend) << i;
    EXPECT_EQ(adjoints[i].x0, adjoint.x0) << i;
  }
}

TEST_F(BackendTest, AFailingRolloutLeavesItsNeighboursUntouched) {
  const auto backend = MakeCpuBackend(model_, 2);
  const auto good = backend->Rollouts(Inputs(), options_, nullptr);
  materials_[2].stretch[0].c[0][0] = std::numeric_limits<double>::quiet_NaN();
  const auto mixed = backend->Rollouts(Inputs(), options_, nullptr);
  EXPECT_NE(mixed[2].status, RolloutStatus::kOk);
  for (const int i : {0, 1, 3, 4}) {
    EXPECT_EQ(mixed[i].status, RolloutStatus::kOk);
    EXPECT_EQ(mixed[i].end.x, good[i].end.x) << i;
  }
}

TEST_F(BackendTest, EmptyBatch) {
  EXPECT_TRUE(MakeCpuBackend(model_, 2)->Rollouts({}, options_, nullptr).empty());
}

}  // namespace
}  // namespace drape
