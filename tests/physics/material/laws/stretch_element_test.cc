// SPDX-License-Identifier: Apache-2.0
// Tests of the stretch kernels of both laws on one triangle.
#include <gmock/gmock.h>

#include <Eigen/Dense>

#include "physics/material/laws/law.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using Columns = DeformationGradient<double>;
using Hessian = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

template <class Laws>
class StretchTest : public testing::Test {};
using StretchLaws = testing::Types<ReferenceStretch, SmoothStretch>;
TYPED_TEST_SUITE(StretchTest, StretchLaws);

Columns RandomColumns(double scale, std::mt19937_64& random) {
  Columns c;
  for (double& value : std::span(&c.u.x, 6)) value = scale * SampleNormal(random);
  return c;
}
// A deformation gradient near the flat rest state, with strains of several per cent.
Columns RandomF(std::mt19937_64& random) {
  Columns F = RandomColumns(0.04, random);
  F.u.x += 1.0;
  F.v.y += 1.0;
  return F;
}

template <class Law>
Eigen::Matrix<double, 6, 1> StepForce(const Law& law, const Columns& F, const StretchTable& table,
                                      const Columns& w, double h) {
  const Columns g = StretchStepForce(EvaluateStretch(law, Green(F), table), F, w, h);
  return Eigen::Map<const Eigen::Matrix<double, 6, 1>>(&g.u.x);
}

TYPED_TEST(StretchTest, StepForceIsForceMinusMatrixTimesVelocity) {
  std::mt19937_64 random(1);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 20; ++i) {
    const Columns F = RandomF(random), w = RandomColumns(1.0, random);
    const auto k = EvaluateStretch(law, Green(F), table);
    const Columns f = StretchForce(k, F), Hw = StretchStiffnessTimes(k, F, w);
    const auto g = StepForce(law, F, table, w, 0.05);
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(g[j], 0.05 * (&f.u.x)[j] - 0.0025 * (&Hw.u.x)[j], 1e-13 * g.norm());
  }
}

// Dual numbers over F go directly through the law, without the chain rule over the strains.
TYPED_TEST(StretchTest, DerivativeAgreesWithPlainAutomaticDifferentiation) {
  std::mt19937_64 random(2);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 50; ++i) {
    const Columns F = RandomF(random), w = RandomColumns(1.0, random);
    Hessian Q, expected;
    StretchStepDerivative(law, F, table, w, 0.05, reinterpret_cast<double(*)[6]>(Q.data()));
    DeformationGradient<Dual<6>> seeded;
    for (int j = 0; j < 6; ++j) (&seeded.u.x)[j] = Dual<6>((&F.u.x)[j], j);
    const auto g = StretchStepForce(EvaluateStretch(law, Green(seeded), table), seeded, w, 0.05);
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c) expected(r, c) = (&g.u.x)[r].v[c];
    EXPECT_LT((Q - expected).norm(), 1e-12 * expected.norm());
  }
}

// Central differences: the error decreases with the square of the step until rounding (about
// 1e-16/step) or, for the reference law, a kink within the step dominates; the best step of the
// sweep counts.
TYPED_TEST(StretchTest, DerivativeAgreesWithFiniteDifferences) {
  std::mt19937_64 random(3);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 20; ++i) {
    const Columns F = RandomF(random), w = RandomColumns(1.0, random);
    Hessian Q;
    StretchStepDerivative(law, F, table, w, 0.05, reinterpret_cast<double(*)[6]>(Q.data()));
    double best = 1.0;
    for (double step = 1e-3; step > 1e-8; step /= 10) {
      Hessian differences;
      for (int j = 0; j < 6; ++j) {
        Columns up = F, down = F;
        (&up.u.x)[j] += step;
        (&down.u.x)[j] -= step;
        differences.col(j) =
            (StepForce(law, up, table, w, 0.05) - StepForce(law, down, table, w, 0.05)) /
            (2 * step);
      }
      best = std::min(best, (Q - differences).norm() / Q.norm());
    }
    EXPECT_LT(best, 1e-8);
  }
}

TYPED_TEST(StretchTest, AdjointIsTheTransposedDerivative) {
  std::mt19937_64 random(14);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 50; ++i) {
    const Columns F = RandomF(random), w = RandomColumns(1.0, random),
                  lambda = RandomColumns(1.0, random);
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> along(&lambda.u.x);
    Hessian Q;
    StretchStepDerivative(law, F, table, w, 0.05, reinterpret_cast<double(*)[6]>(Q.data()));
    const StretchAdjoint adjoint = AdjStretchStep(law, F, table, w, 0.05, lambda);
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> adj_F(&adjoint.adj_F.u.x);
    EXPECT_LT((adj_F - Q.transpose() * along).norm(), 1e-12 * Q.norm() * along.norm());
    // g·λ is linear in the stiffnesses, so that their contributions sum to it.
    double c[kStretchCols], sum = 0.0;
    law.Stiffness(Green(F), table, c);
    for (int m = 0; m < kStretchCols; ++m) sum += c[m] * adjoint.adj_stiffness[m];
    const double work = StepForce(law, F, table, w, 0.05).dot(along);
    EXPECT_NEAR(sum, work, 1e-12 * Q.norm() * along.norm());
    const double of_force = StepForce(law, F, table, Columns{}, 0.05).dot(along);
    EXPECT_NEAR(-0.05 * 0.05 * adjoint.stiffness_work, work - of_force,  // g = h·f − h²·H·w
                1e-12 * Q.norm() * along.norm());
  }
}

TYPED_TEST(StretchTest, StepMatrixIsSymmetricAndPositive) {
  std::mt19937_64 random(4);
  const TypeParam law;
  StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 50; ++i) {
    const Columns F = RandomF(random);
    const auto k = EvaluateStretch(law, Green(F), table);
    Hessian H;
    for (int j = 0; j < 6; ++j) {
      Columns unit{};
      (&unit.u.x)[j] = 1.0;
      const Columns column = StretchStiffnessTimes(k, F, unit);
      H.col(j) = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(&column.u.x);
    }
    EXPECT_LT((H - H.transpose()).norm(), 1e-14 * H.norm());
    const Eigen::SelfAdjointEigenSolver<Hessian> eigen(H);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues()[5]);
  }
}

TYPED_TEST(StretchTest, FloatAgreesTo1em5) {
  std::mt19937_64 random(5);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 20; ++i) {
    const Columns F = RandomF(random);
    const DeformationGradient<float> f{{float(F.u.x), float(F.u.y), float(F.u.z)},
                                       {float(F.v.x), float(F.v.y), float(F.v.z)}};
    double c[kStretchCols];
    float c_float[kStretchCols];
    law.Stiffness(Green(F), table, c);
    law.Stiffness(GreenStrain<float>(Green(f)), table, c_float);
    for (int m = 0; m < kStretchCols; ++m) EXPECT_NEAR(c_float[m], c[m], 1e-5 * c[0]);
  }
}

// A cloth turned by 90°, with its table turned back, exerts the same forces [MODEL, M59]. The shear
// lies outside the first strain cell, where the reference grid prefers the weft (0° if i ≥ j
// [MODEL, M16]).
TYPED_TEST(StretchTest, QuarterTurnOfTheMaterialSwapsC11AndC22) {
  std::mt19937_64 random(6);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  StretchTable turned;
  for (int r = 0; r < kStretchRows; ++r) {
    const double* from = table.c[r == 0 ? 0 : 6 - r];  // direction φ ↔ 90° − φ
    const double row[] = {from[2], from[1], from[0], from[3]};
    std::copy(row, row + kStretchCols, turned.c[r]);
  }
  for (int i = 0; i < 50; ++i) {
    GreenStrain<double> G = Green(RandomF(random));
    G.uv += 0.25;
    double c[kStretchCols], swapped[kStretchCols];
    law.Stiffness(G, table, c);
    law.Stiffness(GreenStrain<double>{G.vv, G.uu, -G.uv}, turned, swapped);
    const double expected[] = {c[2], c[1], c[0], c[3]};
    for (int m = 0; m < kStretchCols; ++m) EXPECT_NEAR(swapped[m], expected[m], 1e-12 * c[0]);
  }
}

TYPED_TEST(StretchTest, StiffnessByTableIsItsDerivative) {
  std::mt19937_64 random(7);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 20; ++i) {
    const GreenStrain<double> G = Green(RandomF(random));
    double c[kStretchCols], by_entry[kStretchRows][kStretchCols];
    law.Stiffness(G, table, c, by_entry);
    for (int m = 0; m < kStretchCols; ++m) {  // linear in the table
      double sum = 0.0;
      for (int r = 0; r < kStretchRows; ++r) sum += by_entry[r][m] * table.c[r][m];
      EXPECT_NEAR(sum, c[m], 1e-12 * c[0]);
    }
  }
}

TEST(ReferenceStretchTest, NegativeNodesCountAsZero) {
  StretchTable table;
  for (auto& row : table.c)
    for (double& entry : row) entry = -1.0;
  double c[kStretchCols], by_entry[kStretchRows][kStretchCols];
  const GreenStrain<double> G{0.01, -0.02, 0.005};
  ReferenceStretch().Stiffness(G, table, c, by_entry);
  for (double value : c) EXPECT_EQ(value, 0.0);
  for (const auto& row : by_entry)
    for (double value : row) EXPECT_EQ(value, 0.0);
}

TEST(SmoothStretchTest, ContinuousAtZeroStrainFromAllDirections) {
  const StretchTable table = test::TestMaterial().stretch[0];
  double at_rest[kStretchCols];
  SmoothStretch().Stiffness(GreenStrain<double>{0, 0, 0}, table, at_rest);
  for (int i = 0; i < 16; ++i) {
    const double angle = i * M_PI / 8, size = 1e-7;
    double c[kStretchCols];
    SmoothStretch().Stiffness(GreenStrain<double>{size * std::cos(angle), -size * std::cos(angle),
                                                  size * std::sin(angle)},
                              table, c);
    for (int m = 0; m < kStretchCols; ++m) EXPECT_NEAR(c[m], at_rest[m], 1e-5 * at_rest[0]);
  }
}
}  // namespace
}  // namespace drape
