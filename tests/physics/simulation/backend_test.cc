// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <limits>

#include "tests/physics/cloth_fixture.h"
#include "tests/physics/summed_tangents.h"

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
      dL_dx_.push_back(test::RandomMatrix(model_->num_dofs(), i % 2 + 1, random_));
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
  std::vector<RowMatrix> dL_dx_;
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
  const auto adjoints = backend->Adjoints(Inputs(), recordings, dL_dx_, options_);
  ASSERT_EQ(rollouts.size(), kBatch);
  StepSolver solver(model_);
  for (int i = 0; i < kBatch; ++i) {
    Recording recording;
    const auto rollout = Rollout(solver, materials_[i], starts_[i], options_, &recording);
    const auto tangent = RolloutTangent(solver, materials_[i], materials_[i], starts_[i], options_);
    const auto adjoint = RolloutAdjoint(solver, materials_[i], options_, recording, dL_dx_[i]);
    EXPECT_EQ(rollouts[i].end.x, rollout.end.x) << i;
    EXPECT_EQ(recordings[i].x.back(), rollout.end.x) << i;
    EXPECT_EQ(tangents[i].dx, tangent.dx) << i;
    EXPECT_EQ(adjoints[i].material.stretch, adjoint.material.stretch) << i;
    EXPECT_EQ(adjoints[i].material.bend, adjoint.material.bend) << i;
    EXPECT_EQ(adjoints[i].x0, adjoint.x0) << i;
  }
}

// A drape that is alone has all threads for its factorisations.
TEST_F(BackendTest, ThreadsOfOneDrapeChangeNoBit) {
  model_ = test::SmallDisc("smooth", 1200);
  const MaterialField material = test::TestMaterial();
  const State start = test::NoisyStart(*model_, 1e-3, random_);
  const std::vector<RolloutInput> one = {{&material, &start}};
  const auto alone = MakeCpuBackend(model_, 1)->Rollouts(one, options_, nullptr);
  const auto backend = MakeCpuBackend(model_, 3);
  const auto threaded = backend->Rollouts(one, options_, nullptr);
  const auto batch = backend->Rollouts({{one[0], one[0]}}, options_, nullptr);
  EXPECT_EQ(threaded[0].status, RolloutStatus::kOk);
  EXPECT_TRUE(threaded[0].end.x == alone[0].end.x);
  EXPECT_TRUE(batch[1].end.x == alone[0].end.x);
}

// field + step·change, with a table for each element.
MaterialField AddScaled(const MaterialField& field, double step, const MaterialField& change) {
  MaterialField sum = change;
  for (std::size_t f = 0; f < sum.stretch.size(); ++f)
    for (int k = 0; k < kStretchEntries; ++k)
      (&sum.stretch[f].c[0][0])[k] = (&field.stretch[field.stretch.size() > 1 ? f : 0].c[0][0])[k] +
                                     step * (&change.stretch[f].c[0][0])[k];
  for (std::size_t e = 0; e < sum.bend.size(); ++e)
    for (int k = 0; k < kBendEntries; ++k)
      (&sum.bend[e].b[0][0])[k] = (&field.bend[field.bend.size() > 1 ? e : 0].b[0][0])[k] +
                                  step * (&change.bend[e].b[0][0])[k];
  sum.density = field.density;
  return sum;
}

// Drapes at rest, and a random change of every table entry.
class EquilibriumJvpTest : public BackendTest {
 protected:
  EquilibriumJvpTest() {
    const auto relaxed = backend_->Rollouts(Inputs(), {.h = 0.1, .steps = 60}, nullptr);
    for (int i = 0; i < kBatch; ++i) starts_[i] = relaxed[i].end;
    const auto rest = backend_->Equilibria(Inputs(), {});
    for (int i = 0; i < kBatch; ++i) {
      starts_[i].x = rest[i].x;
      changes_.push_back(test::Scatter(materials_[i], model_->mesh, 0.5, random_));
    }
    for (const MaterialField& change : changes_) pointers_.push_back(&change);
  }
  std::unique_ptr<Backend> backend_ = MakeCpuBackend(model_, 2);
  std::vector<MaterialField> changes_;
  std::vector<const MaterialField*> pointers_;
};

TEST_F(EquilibriumJvpTest, IsTheSumOfTheTangentsColumns) {
  const auto found = backend_->EquilibriumJvp(Inputs(), pointers_);
  const auto expected = test::SumEquilibriumTangents(*backend_, Inputs(), pointers_);
  int solved = 0;
  for (int i = 0; i < kBatch; ++i) {
    ASSERT_EQ(found[i].size(), expected[i].size()) << i;
    if (found[i].size() == 0) continue;
    ++solved;
    EXPECT_LT((found[i] - expected[i]).norm(), 1e-10 * expected[i].norm()) << i;
  }
  EXPECT_GE(solved, 3);
}

TEST_F(EquilibriumJvpTest, IsTheChangeOfTheDrape) {
  const auto found = backend_->EquilibriumJvp(Inputs(), pointers_);
  const std::vector<MaterialField> fields = materials_;
  const auto drapes_at = [&](double step) {
    for (int i = 0; i < kBatch; ++i) materials_[i] = AddScaled(fields[i], step, changes_[i]);
    return backend_->Equilibria(Inputs(), {.tolerance = 1e-12});
  };
  const double h = 1e-4;
  const auto plus = drapes_at(h), minus = drapes_at(-h);
  for (int i = 0; i < kBatch; ++i) {
    if (found[i].size() == 0) continue;
    const Eigen::VectorXd difference = (plus[i].x - minus[i].x) / (2 * h);
    EXPECT_LT((found[i] - difference).norm(), 1e-4 * difference.norm()) << i;
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
