// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <thread>
#include <vector>

#include "cuda/factor/multifrontal.h"
#include "physics/cloth/assembly/assembly.h"
#include "tests/cuda/engine/gpu_fixture.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

class DeviceSolverTest : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    DRAPE_NEEDS_GPU();
    solver_ = MakeDeviceSolver(model_->pattern, FindDevices()[0]);
  }
  BlockMatrix MakeStepMatrix(const BlockPattern& pattern) {
    ClothModel model = *model_;
    model.pattern = pattern;
    BlockMatrix A(pattern);
    Eigen::VectorXd force;
    AssembleStep(model, test::TestMaterial(), test::NoisyStart(model, 1e-3, random_).x, 0.05, force,
                 A);
    return A;
  }
  static void ExpectSolvesAsTheHost(LinearSolver& solver, const BlockPattern& pattern,
                                    const BlockMatrix& A) {
    std::mt19937_64 random(2);
    const auto host = MakeLinearSolver(pattern);
    ASSERT_TRUE(host->Factor(A));
    ASSERT_TRUE(solver.Factor(A));
    const RowMatrix b = test::RandomMatrix(3 * pattern.num_vertices(), 3, random);
    RowMatrix expected = b, x = b, of_saved = b;
    host->Solve(expected);
    solver.Solve(x);
    EXPECT_LT(test::RelativeError(x, expected), 1e-10);
    Eigen::VectorXd column = b.col(1);
    solver.Solve(column);
    EXPECT_EQ(column, Eigen::VectorXd(x.col(1)));
    std::vector<double> saved;
    solver.SaveFactor(saved);
    EXPECT_EQ(saved.size() * sizeof(double), solver.factor_bytes());
    solver.SolveSaved(saved, of_saved);
    EXPECT_EQ(of_saved, x);
  }

  std::mt19937_64 random_{9};
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", GetParam());
  std::unique_ptr<LinearSolver> solver_;
};

TEST_P(DeviceSolverTest, SolvesAsTheHost) {
  for (int round = 0; round < 2; ++round)
    ExpectSolvesAsTheHost(*solver_, model_->pattern, MakeStepMatrix(model_->pattern));
}

TEST_P(DeviceSolverTest, AdaptsToBlocksOfContact) {
  const int n = model_->mesh.num_vertices();
  for (const int groups : {2, 40}) {
    std::vector<std::array<int, 4>> more;
    for (int k = 0; k < groups; ++k) more.push_back({k, n / 3 + k, n / 2 + k, n - 1 - k});
    const BlockPattern touching = AddGroups(model_->pattern, more);
    BlockMatrix A = MakeStepMatrix(touching);
    for (const auto& group : more)
      for (const int i : group)
        for (const int j : group) A.AddScaledIdentity(touching.Find(i, j), i == j ? 3.0 : -1.0);
    const auto adapted = solver_->Adapt(touching);
    ExpectSolvesAsTheHost(*adapted, touching, A);
    ExpectSolvesAsTheHost(*adapted->Adapt(model_->pattern), model_->pattern,
                          MakeStepMatrix(model_->pattern));
  }
}

TEST_P(DeviceSolverTest, NotPositiveDefiniteIsFalseAndDoesNotStick) {
  BlockMatrix A = MakeStepMatrix(model_->pattern);
  const BlockMatrix good = A;
  A.AddScaledIdentity(model_->pattern.diagonal[model_->mesh.num_vertices() / 2], -1e3);
  EXPECT_FALSE(solver_->Factor(A));
  ExpectSolvesAsTheHost(*solver_, model_->pattern, good);
}

TEST_P(DeviceSolverTest, ClonesWorkOnThreadsOfTheirOwnWithTheSameBits) {
  const BlockMatrix A = MakeStepMatrix(model_->pattern);
  const Eigen::VectorXd b = test::RandomMatrix(model_->num_dofs(), 1, random_);
  std::vector<Eigen::VectorXd> x(3, b);
  std::vector<std::thread> threads;
  for (Eigen::VectorXd& own : x)
    threads.emplace_back([&] {
      const auto clone = solver_->Clone();
      clone->SetThreads(2);
      for (int round = 0; round < 5; ++round) {
        own = b;
        if (clone->Factor(A)) clone->Solve(own);
      }
    });
  for (std::thread& thread : threads) thread.join();
  Eigen::VectorXd alone = b;
  ASSERT_TRUE(solver_->Factor(A));
  solver_->Solve(alone);
  for (const Eigen::VectorXd& own : x) EXPECT_EQ(own, alone);
}

INSTANTIATE_TEST_SUITE_P(Vertices, DeviceSolverTest, testing::Values(150, 900));

}  // namespace
}  // namespace drape
