// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/linear_solver.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <array>
#include <atomic>
#include <limits>
#include <thread>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::IsEmpty;

class LinearSolverTest : public testing::Test {
 protected:
  BlockMatrix MakeStepMatrix(double level) {
    BlockMatrix A(model_->pattern);
    Eigen::VectorXd force;
    AssembleStep(*model_, test::TestMaterial(level), test::NoisyStart(*model_, 1e-3, random_).x,
                 0.05, force, A);
    return A;
  }
  double Residual(const BlockMatrix& A, const RowMatrix& x, const RowMatrix& b) const {
    RowMatrix product = RowMatrix::Zero(b.rows(), b.cols());
    AddMultiply(model_->pattern, A, x, product);
    return (product - b).norm() / b.norm();
  }
  std::mt19937_64 random_{5};
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", 300);
  std::unique_ptr<LinearSolver> solver_ = MakeLinearSolver(model_->pattern);
};

TEST_F(LinearSolverTest, SolvesOneAndManyRightHandSides) {
  const BlockMatrix A = MakeStepMatrix(1.0);
  ASSERT_TRUE(solver_->Factor(A));
  for (const int m : {1, 2, 3, 39, 72}) {
    const RowMatrix b = test::RandomMatrix(model_->num_dofs(), m, random_);
    RowMatrix x = b;
    solver_->Solve(x);
    EXPECT_LT(Residual(A, x, b), 1e-11) << m << " right-hand sides";
    Eigen::VectorXd column = b.col(m - 1);
    solver_->Solve(column);
    EXPECT_LT((column - x.col(m - 1)).norm(), 1e-11 * column.norm());
  }
}

TEST_F(LinearSolverTest, SolversMadeAtTheSameTimeAreAlike) {
  const BlockMatrix A = MakeStepMatrix(1.0);
  const RowMatrix b = test::RandomMatrix(model_->num_dofs(), 1, random_);
  const auto solve = [&] {
    const std::unique_ptr<LinearSolver> solver = MakeLinearSolver(model_->pattern);
    RowMatrix x = b;
    EXPECT_TRUE(solver->Factor(A));
    solver->Solve(x);
    return x;
  };
  const RowMatrix alone = solve();
  constexpr int kThreads = 4, kRounds = 50;
  std::atomic<int> others = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i)
    threads.emplace_back([&] {
      for (int round = 0; round < kRounds; ++round) others += solve() != alone;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(others, 0);
}

TEST_F(LinearSolverTest, NotPositiveDefiniteIsFalseAndDoesNotStick) {
  BlockMatrix A = MakeStepMatrix(1.0);
  const BlockMatrix good = A;
  A.AddScaledIdentity(model_->pattern.diagonal[40], -1e3);
  EXPECT_FALSE(solver_->Factor(A));
  ASSERT_TRUE(solver_->Factor(good));
  const RowMatrix b = test::RandomMatrix(model_->num_dofs(), 2, random_);
  RowMatrix x = b;
  solver_->Solve(x);
  EXPECT_LT(Residual(good, x, b), 1e-11);
}

TEST_F(LinearSolverTest, CloneHasItsOwnNumbers) {
  const BlockMatrix A = MakeStepMatrix(1.0), B = MakeStepMatrix(3.0);
  ASSERT_TRUE(solver_->Factor(A));
  const auto clone = solver_->Clone();
  ASSERT_TRUE(clone->Factor(B));
  const RowMatrix b = test::RandomMatrix(model_->num_dofs(), 4, random_);
  RowMatrix x = b, y = b;
  solver_->Solve(x);
  solver_.reset();  // the clone outlives its origin
  clone->Solve(y);
  EXPECT_LT(Residual(A, x, b), 1e-11);
  EXPECT_LT(Residual(B, y, b), 1e-11);
}

TEST_F(LinearSolverTest, SavedFactorSolvesBitForBit) {
  const BlockMatrix A = MakeStepMatrix(1.0), B = MakeStepMatrix(3.0);
  ASSERT_TRUE(solver_->Factor(A));
  const RowMatrix b = test::RandomMatrix(model_->num_dofs(), 3, random_);
  RowMatrix before = b, after = b;
  solver_->Solve(before);
  std::vector<double> saved;
  solver_->SaveFactor(saved);
  EXPECT_EQ(saved.size() * sizeof(double), solver_->factor_bytes());
  ASSERT_TRUE(solver_->Factor(B));
  solver_->SolveSaved(saved, after);
  EXPECT_EQ(before, after);
  // The present factor is unchanged.
  RowMatrix x = b;
  solver_->Solve(x);
  EXPECT_LT(Residual(B, x, b), 1e-11);
}

TEST_F(LinearSolverTest, ThreadsChangeNoBit) {
  model_ = test::SmallDisc("smooth", 1500);
  const BlockMatrix A = MakeStepMatrix(1.0);
  const RowMatrix b = test::RandomMatrix(model_->num_dofs(), 39, random_);
  std::vector<double> factor;
  RowMatrix many;
  Eigen::VectorXd one;
  for (const int threads : {1, 2, 5}) {
    const auto solver = MakeLinearSolver(model_->pattern, threads)->Clone();
    for (int round = 0; round < 3; ++round) {  // the order in which threads take tasks differs
      SCOPED_TRACE(testing::Message() << threads << " threads, round " << round);
      ASSERT_TRUE(solver->Factor(A));
      std::vector<double> saved;
      solver->SaveFactor(saved);
      RowMatrix x = b;
      solver->Solve(x);
      Eigen::VectorXd y = b.col(0);
      solver->Solve(y);
      EXPECT_LT(Residual(A, x, b), 1e-11);
      if (factor.empty()) {
        factor = saved;
        many = x;
        one = y;
      }
      EXPECT_TRUE(saved == factor);
      EXPECT_TRUE(x == many);
      EXPECT_TRUE(y == one);
    }
  }
}

TEST_F(LinearSolverTest, AFlagEndsAFactorisationOnThreads) {
  model_ = test::SmallDisc("smooth", 1500);
  const BlockMatrix A = MakeStepMatrix(1.0);
  const auto solver = MakeLinearSolver(model_->pattern, 2);
  std::atomic<bool> cancel = true;
  {
    const Interruptible interruptible(*solver, &cancel);
    EXPECT_FALSE(solver->Factor(A));
  }
  EXPECT_TRUE(solver->Factor(A));
}

TEST_F(LinearSolverTest, TransposedProductIsTheAdjoint) {
  BlockMatrix A(model_->pattern);
  for (double& value : A.value) value = SampleNormal(random_);
  const int n = model_->num_dofs();
  const RowMatrix x = test::RandomMatrix(n, 3, random_), y = test::RandomMatrix(n, 3, random_);
  RowMatrix Ax = RowMatrix::Zero(n, 3), Aty = Ax;
  AddMultiply(model_->pattern, A, x, Ax);
  AddTransposeMultiply(model_->pattern, A, y, Aty);
  EXPECT_NEAR(y.cwiseProduct(Ax).sum(), Aty.cwiseProduct(x).sum(), 1e-12 * Ax.norm() * y.norm());
}

// The decisions of the recurrence on artificial norms, and the solution of a small system by them.

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(CgwRecurrenceTest, ColumnsOfZerosAreSolved) {
  const CgwRecurrence some(std::array{0.0, 2.0, 0.0, 1.0});
  EXPECT_THAT(some.active(), ElementsAre(1, 3));
  EXPECT_EQ(some.status(), CgwStatus::kGoOn);
  EXPECT_EQ(CgwRecurrence(std::array{0.0}).status(), CgwStatus::kSolved);
}

TEST(CgwRecurrenceTest, EachColumnIsSolvedByItsOwnRhs) {
  CgwRecurrence columns(std::array{0.0, 1.0, 1e3, 1e-3});
  columns.Judge(std::array{1.1e-9, 1e-6, 1e-11});
  EXPECT_THAT(columns.active(), ElementsAre(1, 3));
  EXPECT_THAT(columns.kept(), ElementsAre(0, 2));
  EXPECT_EQ(columns.status(), CgwStatus::kGoOn);
  columns.Judge(std::array{1e-10, 1.1e-12});
  EXPECT_THAT(columns.active(), ElementsAre(3));
  EXPECT_THAT(columns.kept(), ElementsAre(1));
  columns.Judge(std::array{1e-12});
  EXPECT_THAT(columns.active(), IsEmpty());
  EXPECT_EQ(columns.status(), CgwStatus::kSolved);
}

TEST(CgwRecurrenceTest, StagnationIsAcceptedBelowRounding) {
  CgwRecurrence columns(std::array{1.0, 1.0});
  columns.Judge(std::array{2e-6, 1.9e-6});
  columns.Judge(std::array{2e-6, 1.9e-6});  // above the bound
  EXPECT_EQ(columns.active().size(), 2u);
  columns.Judge(std::array{9e-7, 9e-7});
  columns.Judge(std::array{8e-7, 9e-8});  // the largest one still decreases, by a ninth
  EXPECT_EQ(columns.active().size(), 2u);
  columns.Judge(std::array{7.3e-7, 9e-8});
  EXPECT_EQ(columns.status(), CgwStatus::kSolved);
}

TEST(CgwRecurrenceTest, GivesUpAfterFortyRounds) {
  CgwRecurrence columns(std::array{1.0}), late(std::array{1.0});
  for (int round = 0; round < 39; ++round) {
    columns.Judge(std::array{1e-3});
    late.Judge(std::array{1e-3});
  }
  EXPECT_EQ(columns.status(), CgwStatus::kGoOn);
  columns.Judge(std::array{1e-3});
  EXPECT_EQ(columns.status(), CgwStatus::kGaveUp);
  late.Judge(std::array{1e-11});
  EXPECT_EQ(late.status(), CgwStatus::kSolved);
}

TEST(CgwRecurrenceTest, NanIsNeverSolved) {
  CgwRecurrence columns(std::array{1.0, 1.0, kNaN});
  for (int round = 0; round < 40; ++round)
    columns.Judge(std::vector<double>(columns.active().size(), round < 2 ? 1e-7 : kNaN));
  EXPECT_EQ(columns.status(), CgwStatus::kGaveUp);
  EXPECT_THAT(columns.active(), ElementsAre(0, 1, 2));
}

// ω is 1 at first, then 1 / (1 + ρ/ρ₋/ω₋).
TEST(CgwRecurrenceTest, WeightsFollowTheirColumns) {
  CgwRecurrence columns(std::array{1.0, 1.0, 1.0});
  EXPECT_THAT(columns.Weights(std::array{8.0, 5.0, 4.0}), ElementsAre(1.0, 1.0, 1.0));
  columns.Judge(std::array{0.5, 0.0, 0.5});
  EXPECT_THAT(columns.Weights(std::array{2.0, 2.0}), ElementsAre(DoubleEq(0.8), DoubleEq(2. / 3)));
  columns.Judge(std::array{0.1, 0.1});
  EXPECT_THAT(columns.Weights(std::array{1.0, 0.0}),
              ElementsAre(DoubleEq(1.0 / (1.0 + 0.5 / 0.8)), 1.0));
  columns.Judge(std::array{0.1, 0.1});
  EXPECT_EQ(columns.Weights(std::array{1.0, 0.0})[1], 1.0);  // squares that underflow
}

std::vector<double> Norms(const Eigen::MatrixXd& a) {
  const Eigen::RowVectorXd norms = a.colwise().norm();
  return {norms.begin(), norms.end()};
}

TEST(CgwRecurrenceTest, SolvesWithTheFactorOfTheSymmetricPart) {
  Eigen::MatrixXd K = Eigen::VectorXd::LinSpaced(12, 1.0, 4.0).asDiagonal();
  for (int i = 0; i + 1 < K.rows(); ++i) K(i, i + 1) = 0.6, K(i + 1, i) = -0.2;
  const Eigen::LDLT<Eigen::MatrixXd> symmetric(0.5 * (K + K.transpose()));
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(K.rows(), 3);
  B.col(0).setOnes();
  B.col(2).setLinSpaced(1.0, -5.0);
  CgwRecurrence columns(Norms(B));
  ASSERT_THAT(columns.active(), ElementsAre(0, 2));
  Eigen::MatrixXd R = B(Eigen::all, columns.active()), X = 0.0 * R, before = X;
  int rounds = 0;
  for (; columns.status() == CgwStatus::kGoOn; ++rounds) {
    const Eigen::MatrixXd Z = symmetric.solve(R);
    const Eigen::RowVectorXd square = R.cwiseProduct(Z).colwise().sum();
    const auto weight = columns.Weights({square.data(), std::size_t(square.size())});
    const Eigen::Map<const Eigen::RowVectorXd> omega(weight.data(), square.size());
    const Eigen::MatrixXd next = before + (Z + X - before) * omega.asDiagonal();
    before = X;
    X = next;
    R = B(Eigen::all, columns.active()) - K * X;
    const Eigen::MatrixXd rhs = B(Eigen::all, columns.active());
    columns.Judge(Norms(R));
    if (columns.kept().size() == static_cast<std::size_t>(X.cols())) continue;
    EXPECT_LT((K * X - rhs).col(0).norm(), 1e-8 * rhs.col(0).norm());
    for (Eigen::MatrixXd* each : {&R, &before, &X})
      *each = (*each)(Eigen::all, columns.kept()).eval();
  }
  EXPECT_EQ(columns.status(), CgwStatus::kSolved);
  EXPECT_LT(rounds, 25);  // without the weights: more than 40
}

}  // namespace
}  // namespace drape
