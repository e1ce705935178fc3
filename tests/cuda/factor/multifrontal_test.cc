// SPDX-License-Identifier: Apache-2.0
#include "cuda/factor/multifrontal.h"

#include <gmock/gmock.h>

#include <algorithm>

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

}  // namespace
}  // namespace drape
