// SPDX-License-Identifier: Apache-2.0
// The decisions of the recurrence on artificial norms, and the solution of a small system by them.
#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <array>
#include <limits>

#include "physics/linalg/linear_solver.h"

namespace drape {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::IsEmpty;

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
