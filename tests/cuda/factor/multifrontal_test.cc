// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/multifrontal.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "cuda/device/device.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/linalg/linear_solver.h"
#include "tests/cuda/engine/gpu_fixture.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using test::RelativeError;

// Step matrices of one mesh at different shapes, solved on the device and on the host.
class MultifrontalTest : public testing::TestWithParam<int> {
 protected:
  void SetUp() override {
    DRAPE_NEEDS_GPU();
    info_ = FindDevices()[0];
    plan_ = MakeFrontPlan(model_->pattern, model_->mesh.uv, {.shared_bytes = info_.shared_bytes});
    for (int s = 0; s < kSlots; ++s) {
      matrices_.emplace_back(model_->pattern);
      Eigen::VectorXd force;
      AssembleStep(*model_, test::TestMaterial(1.0 + s), test::NoisyStart(*model_, 1e-3, random_).x,
                   0.05, force, matrices_.back());
    }
  }

  // Lower triangle in the plan's order.
  std::vector<double> Entries(const BlockMatrix& A) const {
    const BlockPattern& p = model_->pattern;
    std::vector<double> values;
    for (const FrontEntry& entry : plan_.entries) {
      const int i = plan_.vertex[entry.row], j = plan_.vertex[entry.column];
      const auto row = p.column.begin() + p.row_start[i];
      const auto b = std::lower_bound(row, p.column.begin() + p.row_start[i + 1], j);
      const double* block = A.block(static_cast<int>(b - p.column.begin()));
      values.insert(values.end(), block, block + 9);
    }
    return values;
  }
  RowMatrix Permuted(const RowMatrix& b) const {
    RowMatrix result(b.rows(), b.cols());
    for (int v = 0; v < plan_.num_vertices(); ++v)
      result.middleRows<3>(3 * plan_.position[v]) = b.middleRows<3>(3 * v);
    return result;
  }

  static constexpr int kSlots = 3;
  std::mt19937_64 random_{7};
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", GetParam());
  DeviceInfo info_;
  FrontPlan plan_;
  std::vector<BlockMatrix> matrices_;
};

TEST_P(MultifrontalTest, SolvesAreEquivalentToReference) {
  const Multifrontal multifrontal(plan_, info_.shared_bytes);
  const Streams streams;
  const int dofs = model_->num_dofs();
  std::vector<double> values;
  for (const BlockMatrix& A : matrices_)
    for (const double a : Entries(A)) values.push_back(a);
  const DeviceBuffer<double> matrix(values);
  DeviceBuffer<double> factor(kSlots * plan_.factor_size), update(kSlots * plan_.update_size);
  DeviceBuffer<int> failed(std::vector<int>(kSlots, 0));
  for (const int columns : {1, 2, 39, 72, 200}) {
    std::vector<RowMatrix> rhs, expected;
    std::vector<double> host;
    for (const BlockMatrix& A : matrices_) {
      rhs.push_back(test::RandomMatrix(dofs, columns, random_));
      auto solver = MakeLinearSolver(model_->pattern);
      ASSERT_TRUE(solver->Factor(A));
      expected.push_back(rhs.back());
      solver->Solve(expected.back());
      expected.back() = Permuted(expected.back());
      const RowMatrix b = Permuted(rhs.back());
      host.insert(host.end(), b.data(), b.data() + b.size());
    }
    DeviceBuffer<double> b(host), x(host.size()),
        vectors(std::size_t{1} * kSlots * plan_.vector_size * columns);
    const FactorView numbers{matrix.data(), {factor.data()}, update.data(), failed.data()};
    const auto check = [&](const char* what) {
      streams.Synchronize();
      CopyToHost<double>(x.data(), host);
      for (int s = 0; s < kSlots; ++s)
        EXPECT_LT(RelativeError(
                      Eigen::Map<const RowMatrix>(host.data() + s * dofs * columns, dofs, columns),
                      expected[s]),
                  1e-10)
            << what << ", slot " << s << ", columns " << columns;
    };
    if (columns == 1) {
      multifrontal.FactorAndSolve(numbers, b.data(), x.data(), kSlots, kSlots, streams.main());
      check("with the factorisation");
      multifrontal.FactorAndSolve(numbers, b.data(), x.data(), 1, 1, streams.main());
    }
    multifrontal.FactorAndSolve(numbers, nullptr, nullptr, kSlots, kSlots, streams.main());
    multifrontal.Solve({factor.data()}, {b.data(), x.data(), vectors.data(), columns}, kSlots,
                       streams.main());
    check("with the stored factor");
  }
  std::vector<int> flags(kSlots);
  CopyToHost<int>(failed.data(), flags);
  EXPECT_THAT(flags, testing::Each(0));
}

TEST_P(MultifrontalTest, FlagsTheSlotThatIsNotPositiveDefinite) {
  const Multifrontal multifrontal(plan_, info_.shared_bytes);
  const Streams streams;
  matrices_[1].AddScaledIdentity(model_->pattern.diagonal[model_->mesh.num_vertices() / 2], -1e3);
  std::vector<double> values;
  for (const BlockMatrix& A : matrices_)
    for (const double a : Entries(A)) values.push_back(a);
  const DeviceBuffer<double> matrix(values);
  DeviceBuffer<double> factor(kSlots * plan_.factor_size), update(kSlots * plan_.update_size);
  DeviceBuffer<int> failed(std::vector<int>(kSlots, 0));
  multifrontal.FactorAndSolve({matrix.data(), {factor.data()}, update.data(), failed.data()},
                              nullptr, nullptr, kSlots, kSlots, streams.main());
  streams.Synchronize();
  std::vector<int> flags(kSlots);
  CopyToHost<int>(failed.data(), flags);
  EXPECT_THAT(flags, testing::ElementsAre(0, 1, 0));
}

TEST(DeviceBuffer, TooLargeSaysTheNumbers) {
  DRAPE_NEEDS_GPU();
  const std::size_t total = QueryMemory().total;
  try {
    DeviceBuffer<char> buffer(2 * total);
    FAIL() << "twice the device's memory was allocated";
  } catch (const DeviceMemoryError& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("needs " + std::to_string(2 * total >> 20) + " MB"));
    EXPECT_THAT(error.what(),
                testing::HasSubstr("of " + std::to_string(total >> 20) + " MB are free"));
  }
  DeviceBuffer<char> next(1);  // nothing is left of the failure
  EXPECT_NE(next.data(), nullptr);
}

INSTANTIATE_TEST_SUITE_P(Meshes, MultifrontalTest, testing::Values(100, 150, 300, 1200));

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
