// SPDX-License-Identifier: Apache-2.0
// A nudge tells drapes at rest from shapes that are not.
#include "solver/forward/settle.h"

#include "tests/solver/solver_fixture.h"

namespace drape::test {
namespace {

class NudgeTest : public testing::Test {
 protected:
  NudgedDrape NudgeShape(const Eigen::VectorXd& x, const EquilibriumOptions& options = {}) const {
    return Nudge(*backend_, material_, x, options);
  }

  std::unique_ptr<Backend> backend_ = SmoothDisc(100);
  MaterialField material_ = TestMaterial();
  Eigen::VectorXd drape_ = Settled(*backend_, material_, RandomStart(backend_->model(), 1)).x;
};

TEST_F(NudgeTest, ADrapeAtRestReturns) {
  const NudgedDrape nudged = NudgeShape(drape_);
  EXPECT_EQ(nudged.status, EquilibriumStatus::kStable);
  EXPECT_LT(nudged.drift, 1e-6);
}

TEST_F(NudgeTest, AShapeBesideADrapeMovesThere) {
  const State waves = RandomStart(backend_->model(), 2, 2e-3);
  const Eigen::VectorXd beside = drape_ + waves.x - backend_->model().mesh.rest_x;
  const NudgedDrape nudged = NudgeShape(beside);
  EXPECT_EQ(nudged.status, EquilibriumStatus::kStable);
  EXPECT_LT((nudged.x - drape_).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT(nudged.drift, 1e-3);
}

TEST_F(NudgeTest, WhatDoesNotComeToRestKeepsItsShape) {
  const Eigen::VectorXd flat = backend_->model().mesh.rest_x;
  const NudgedDrape nudged = NudgeShape(flat, {.max_iterations = 1});
  EXPECT_EQ(nudged.status, EquilibriumStatus::kNotConverged);
  EXPECT_EQ(nudged.x, flat);
}

}  // namespace
}  // namespace drape::test
