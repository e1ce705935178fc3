// SPDX-License-Identifier: Apache-2.0
// Stretch tables that resist all strains whatever their log factors are [METHODS, P2].
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "solver/fit/parametrisation.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

constexpr int kC11 = 0, kC12 = 1, kC22 = 2;

double Coupling(const StretchTable& table, int row) {
  return table.c[row][kC12] / std::sqrt(table.c[row][kC11] * table.c[row][kC22]);
}

// The rows have couplings from 0.02 to 0.98.
StretchTable ManyCouplings() {
  StretchTable table = test::TestMaterial().stretch[0];
  const double couplings[kStretchRows] = {0.02, 0.3, 0.6, 0.9, 0.97, 0.98};
  for (int r = 0; r < kStretchRows; ++r)
    table.c[r][kC12] = couplings[r] * std::sqrt(table.c[r][kC11] * table.c[r][kC22]);
  return table;
}

Eigen::VectorXd RandomFactors(double size, int seed) {
  std::mt19937_64 random(seed);
  return size * test::RandomMatrix(kStretchEntries, 1, random);
}

Eigen::VectorXd Logs(const StretchTable& table) {
  return Eigen::Map<const Eigen::ArrayXd>(table.entries(), kStretchEntries).abs().log();
}

TEST(CoupledTable, ResistsAllStrainsWhateverTheFactors) {
  const StretchTable base = ManyCouplings();
  for (const double size : {0.1, 1.0, 10.0, 100.0})
    for (int seed = 0; seed < 50; ++seed) {
      const StretchTable table = ApplyLogFactors(base, RandomFactors(size, seed).data());
      EXPECT_TRUE(test::ResistsAllStrains({0.2, {table}, {}})) << size << ' ' << seed;
      for (int r = 0; r < kStretchRows; ++r)
        EXPECT_LE(Coupling(table, r), kLargestCoupling * (1 + 1e-12)) << size << ' ' << seed;
    }
}

TEST(CoupledTable, LogFactorsAreFoundAgain) {
  const StretchTable base = ManyCouplings();
  for (int seed = 0; seed < 20; ++seed) {
    const Eigen::VectorXd eta = RandomFactors(2.0, seed);
    const Eigen::VectorXd found = FindLogFactors(base, ApplyLogFactors(base, eta.data()));
    EXPECT_LT((found - eta).norm(), 1e-9) << seed;
  }
  StretchTable none = base, other_sign = base;
  none.c[0][kC12] = 0.0;
  other_sign.c[0][kC12] *= -1;
  EXPECT_FALSE(FindLogFactors(base, none).allFinite());
  EXPECT_FALSE(FindLogFactors(base, other_sign).allFinite());
  EXPECT_TRUE(FindLogFactors(none, none).isZero());
}

TEST(CoupledTable, IsTheBaseAtZeroToTheBit) {
  const StretchTable base = ManyCouplings();
  const StretchTable table = ApplyLogFactors(base, Eigen::VectorXd::Zero(24).eval().data());
  for (int k = 0; k < kStretchEntries; ++k) EXPECT_EQ(table.entries()[k], base.entries()[k]) << k;
}

// The statement of the header: logit(ρ/ρmax) moves by u.
TEST(CoupledTable, MovesTheLogitOfTheCoupling) {
  const StretchTable base = ManyCouplings();
  const Eigen::VectorXd eta = RandomFactors(1.0, 3);
  const StretchTable table = ApplyLogFactors(base, eta.data());
  const auto logit = [](double coupling) {
    return std::log(coupling / (kLargestCoupling - coupling));
  };
  for (int r = 0; r < kStretchRows; ++r) {
    const double u = eta[4 * r + kC12] - 0.5 * (eta[4 * r + kC11] + eta[4 * r + kC22]);
    EXPECT_NEAR(logit(Coupling(table, r)) - logit(Coupling(base, r)), u, 1e-10) << r;
    for (const int c : {0, 2, 3})
      EXPECT_NEAR(table.c[r][c] / (base.c[r][c] * std::exp(eta[4 * r + c])), 1.0, 1e-14);
  }
}

TEST(CoupledTable, IsALogScaleWhereTheCouplingIsSmall) {
  StretchTable base = test::TestMaterial().stretch[0];
  for (auto& row : base.c) row[kC12] *= 1e-6;
  const Eigen::VectorXd eta = RandomFactors(1.0, 4);
  const Eigen::VectorXd logs = Logs(ApplyLogFactors(base, eta.data())) - Logs(base);
  EXPECT_LT((logs - eta).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(CoupledTable, EqualFactorsKeepTheCoupling) {
  const StretchTable base = ManyCouplings();
  const StretchTable table =
      ApplyLogFactors(base, Eigen::VectorXd::Constant(kStretchEntries, 1.7).eval().data());
  for (int r = 0; r < kStretchRows; ++r)
    EXPECT_NEAR(Coupling(table, r), Coupling(base, r), 1e-15) << r;
}

TEST(CoupledTable, StepsAddUp) {
  StretchTable base = ManyCouplings();
  for (auto& row : base.c) row[kC12] *= 0.8;
  const Eigen::VectorXd one = RandomFactors(0.5, 5), two = RandomFactors(0.5, 6);
  StretchTable between = ApplyLogFactors(base, one.data());
  for (int r = 0; r < kStretchRows; ++r) ASSERT_LE(Coupling(between, r), 0.98) << r;
  EXPECT_LT((Logs(ApplyLogFactors(between, two.data())) -
             Logs(ApplyLogFactors(base, (one + two).eval().data())))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

// A step of h = 1e-5 leaves h²/6 of truncation and 1e-16/h of rounding.
TEST(CoupledTable, DerivativesAgreeWithDifferences) {
  const StretchTable base = ManyCouplings();
  constexpr double kStep = 1e-5;
  for (const double size : {0.0, 0.5, 3.0}) {
    const Eigen::VectorXd eta = RandomFactors(size, 7), direction = RandomFactors(1.0, 8);
    const StretchTable table = ApplyLogFactors(base, eta.data());
    Eigen::VectorXd exact = direction;
    PushLogFactors(base, table, exact.data());
    const Eigen::VectorXd plus = eta + kStep * direction, minus = eta - kStep * direction;
    const Eigen::VectorXd difference =
        (Logs(ApplyLogFactors(base, plus.data())) - Logs(ApplyLogFactors(base, minus.data()))) /
        (2 * kStep);
    EXPECT_LT((difference - exact).cwiseAbs().maxCoeff(), 1e-9) << size;
    const Eigen::VectorXd gradient = RandomFactors(1.0, 9);
    Eigen::VectorXd pulled = gradient;
    PullLogFactors(base, table, pulled.data());
    EXPECT_NEAR(pulled.dot(direction), gradient.dot(exact), 1e-12 * gradient.norm()) << size;
  }
}

// A base near the limit stays where it is and may come nearer to 1, not reach it.
TEST(CoupledTable, ABaseBeyondTheMarginHasALargerOne) {
  StretchTable base = test::TestMaterial().stretch[0];
  for (auto& row : base.c) row[kC12] = 0.996 * std::sqrt(row[kC11] * row[kC22]);
  Eigen::VectorXd eta = Eigen::VectorXd::Zero(kStretchEntries);
  EXPECT_NEAR(Coupling(ApplyLogFactors(base, eta.data()), 2), 0.996, 1e-15);
  eta[4 * 2 + kC12] = 50.0;
  EXPECT_NEAR(Coupling(ApplyLogFactors(base, eta.data()), 2), 0.998, 1e-12);
}

TEST(CoupledTable, ANegativeCouplingIsBoundedToo) {
  StretchTable base = ManyCouplings();
  for (auto& row : base.c) row[kC12] = -row[kC12];
  const StretchTable table = ApplyLogFactors(base, RandomFactors(5.0, 1).data());
  for (int r = 0; r < kStretchRows; ++r) {
    EXPECT_LT(Coupling(table, r), 0.0) << r;
    EXPECT_GE(Coupling(table, r), -kLargestCoupling * (1 + 1e-14)) << r;
  }
}

TEST(CoupledTable, RowsThatDoNotResistStayOnALogScale) {
  StretchTable base = ManyCouplings();
  base.c[0][kC12] = 2.0 * std::sqrt(base.c[0][kC11] * base.c[0][kC22]);
  base.c[1][kC22] = 0.0;
  base.c[2][kC11] = -base.c[2][kC11];
  const Eigen::VectorXd eta = RandomFactors(1.0, 2);
  const StretchTable table = ApplyLogFactors(base, eta.data());
  Eigen::VectorXd change = eta;
  PushLogFactors(base, table, change.data());
  for (int r = 0; r < 3; ++r) {
    const int k = 4 * r + kC12;
    EXPECT_NEAR(table.c[r][kC12] / base.c[r][kC12], std::exp(eta[k]), 1e-13 * std::exp(eta[k]));
    EXPECT_EQ(change[k], eta[k]);
  }
}

}  // namespace
}  // namespace drape
