// SPDX-License-Identifier: Apache-2.0
// Tests of the hinge kernels of both laws on one hinge.
#include <gmock/gmock.h>

#include <Eigen/Dense>

#include "physics/material/laws/law.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12, Eigen::RowMajor>;

template <class Laws>
class BendTest : public testing::Test {};
using BendLaws = testing::Types<ReferenceBend, SmoothBend>;
TYPED_TEST_SUITE(BendTest, BendLaws);

Hinge TestHinge() {
  Hinge hinge{};
  hinge.rest_length = 0.01;
  hinge.rest_area = 9e-5;
  hinge.direction = 0.7;
  return hinge;
}
HingeCorners RandomHinge(std::mt19937_64& random) {
  HingeCorners c{{{0, 0, 0}, {0.01, 0, 0}, {0.006, 0.009, 0}, {0.004, -0.009, 0}}};
  for (double& value : std::span(&c.x[0].x, 12)) value += 3e-3 * SampleNormal(random);
  return c;
}
HingeCorners Moved(HingeCorners c, int i, double step) {
  (&c.x[0].x)[i] += step;
  return c;
}

TEST(HingeGeometryTest, GradientIsThatOfTheAngle) {
  std::mt19937_64 random(8);
  for (int n = 0; n < 50; ++n) {
    const HingeCorners c = RandomHinge(random);
    const HingeGradient gradient = AngleGradient(EvaluateWings(c));
    const Eigen::Map<const Eigen::Matrix<double, 12, 1>> d(&gradient.d[0].x);
    double best = 1.0;
    for (double step = 1e-5; step > 1e-9; step /= 10) {
      Eigen::Matrix<double, 12, 1> differences;
      for (int i = 0; i < 12; ++i)
        differences[i] =
            std::remainder(DihedralAngle(Moved(c, i, step)) - DihedralAngle(Moved(c, i, -step)),
                           2 * M_PI) /
            (2 * step);
      best = std::min(best, (differences - d).norm() / d.norm());
    }
    EXPECT_LT(best, 1e-7);
  }
}

// ∂θ/∂x in dual numbers over all twelve coordinates, from the same wings.
TEST(HingeGeometryTest, HessianAgreesWithAutomaticDifferentiation) {
  using D = Dual<12>;
  std::mt19937_64 random(9);
  for (int n = 0; n < 50; ++n) {
    const HingeCorners c = RandomHinge(random);
    Vec3<D> x[4];
    for (int i = 0; i < 12; ++i) (&x[i / 3].x)[i % 3] = D((&c.x[0].x)[i], i);
    const Vec3<D> e = x[1] - x[0];
    const Wing<D> w0 = EvaluateWing(e, x[2] - x[0], 1.0), w1 = EvaluateWing(e, x[3] - x[0], -1.0);
    const Vec3<D> gradient[4] = {(w0.t - 1.0) * w0.m + (w1.t - 1.0) * w1.m,
                                 (-w0.t) * w0.m + (-w1.t) * w1.m, w0.m, w1.m};
    Matrix12 H = Matrix12::Zero(), expected;
    const HingeRates rates = ComputeRates(EvaluateWings(c));
    for (int side = 0; side < 2; ++side)
      for (int block = 0; block < 16; ++block) {
        Eigen::Matrix<double, 3, 3, Eigen::RowMajor> own;
        own.setZero();
        AddWingHessianBlock(rates.wing[side], 2 + side, block / 4, block % 4, 1.0, own.data());
        H.block<3, 3>(3 * (block / 4), 3 * (block % 4)) += own;
      }
    HingeCorners v;
    for (double& value : std::span(&v.x[0].x, 12)) value = SampleNormal(random);
    const HingeGradient Hv = rates * v;
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j) expected(i, j) = (&gradient[i / 3].x)[i % 3].v[j];
    EXPECT_LT((H - expected).norm(), 1e-12 * expected.norm());
    EXPECT_LT((H - H.transpose()).norm(), 1e-11 * H.norm());
    const Eigen::Map<const Eigen::Matrix<double, 12, 1>> along(&v.x[0].x), product(&Hv.d[0].x);
    EXPECT_LT((product - expected * along).norm(), 1e-12 * expected.norm() * along.norm());
  }
}

template <class Law>
Eigen::Matrix<double, 12, 1> StepForce(const Law& law, const HingeCorners& x, const HingeCorners& w,
                                       double h) {
  const HingeGradient d = AngleGradient(EvaluateWings(x));
  const double theta = DihedralAngle(x);
  const double kappa = HingeStiffness(law, TestHinge(), test::TestMaterial().bend[0], theta);
  return -StepMoment(kappa, law.Measure(theta), Dot(d, w), h) *
         Eigen::Map<const Eigen::Matrix<double, 12, 1>>(&d.d[0].x);
}

TYPED_TEST(BendTest, DerivativeAgreesWithFiniteDifferences) {
  std::mt19937_64 random(10);
  const TypeParam law;
  for (int n = 0; n < 30; ++n) {
    const HingeCorners x = RandomHinge(random);
    HingeCorners w;
    for (double& value : std::span(&w.x[0].x, 12)) value = 0.1 * SampleNormal(random);
    Matrix12 Q;
    BendStepDerivative(law, TestHinge(), test::TestMaterial().bend[0], x, w, 0.05,
                       reinterpret_cast<double(*)[12]>(Q.data()));
    double best = 1.0;
    for (double step = 1e-5; step > 1e-10; step /= 10) {
      Matrix12 differences;
      for (int j = 0; j < 12; ++j)
        differences.col(j) = (StepForce(law, Moved(x, j, step), w, 0.05) -
                              StepForce(law, Moved(x, j, -step), w, 0.05)) /
                             (2 * step);
      best = std::min(best, (Q - differences).norm() / Q.norm());
    }
    EXPECT_LT(best, 1e-6);
  }
}

TYPED_TEST(BendTest, AdjointIsTheTransposedDerivative) {
  std::mt19937_64 random(15);
  const TypeParam law;
  const BendTable table = test::TestMaterial().bend[0];
  for (int n = 0; n < 30; ++n) {
    const HingeCorners x = RandomHinge(random);
    HingeCorners w, lambda;
    for (double& value : std::span(&w.x[0].x, 12)) value = 0.1 * SampleNormal(random);
    for (double& value : std::span(&lambda.x[0].x, 12)) value = SampleNormal(random);
    const Eigen::Map<const Eigen::Matrix<double, 12, 1>> along(&lambda.x[0].x);
    Matrix12 Q;
    BendStepDerivative(law, TestHinge(), table, x, w, 0.05,
                       reinterpret_cast<double(*)[12]>(Q.data()));
    const double theta = DihedralAngle(x);
    double stiffness_work = 0.0;
    const BendAdjoint adjoint =
        AdjBendStep(law, TestHinge(), table, law.Columns(TestHinge(), Dual<1>(theta, 0)), x, w,
                    0.05, lambda, theta, &stiffness_work);
    const Eigen::Map<const Eigen::Matrix<double, 12, 1>> adj_x(&adjoint.adj_x.d[0].x);
    EXPECT_LT((adj_x - Q.transpose() * along).norm(), 1e-12 * Q.norm() * along.norm());
    const double work = StepForce(law, x, w, 0.05).dot(along);
    EXPECT_NEAR(adjoint.adj_kappa * HingeStiffness(law, TestHinge(), table, theta), work,
                1e-12 * std::fabs(work));
    const double of_force = StepForce(law, x, HingeCorners{}, 0.05).dot(along);  // g = h·f − h²·H·w
    EXPECT_NEAR(-0.05 * 0.05 * stiffness_work, work - of_force, 1e-12 * std::fabs(of_force));
  }
}

TYPED_TEST(BendTest, MomentIsMinusTheDerivativeOfTheEnergy) {
  const TypeParam law;
  const BendTable table = test::TestMaterial().bend[0];
  const Hinge hinge = TestHinge();
  for (double theta = -2.9; theta < 3.0; theta += 0.0917) {
    const double step = 1e-5;
    const double slope = (BendEnergy(law, hinge, table, theta + step) -
                          BendEnergy(law, hinge, table, theta - step)) /
                         (2 * step);
    const double moment = HingeStiffness(law, hinge, table, theta) * law.Measure(theta).value;
    EXPECT_NEAR(slope, moment, 1e-8 * HingeStiffness(law, hinge, table, M_PI)) << "theta " << theta;
  }
}

TYPED_TEST(BendTest, StiffnessByTableIsItsDerivative) {
  const TypeParam law;
  const BendTable table = test::TestMaterial().bend[0];
  for (double theta = -1.5; theta < 1.6; theta += 0.11) {
    BendTable by_entry;
    double sum = 0.0;
    HingeStiffnessByTable(law, TestHinge(), table, law.Columns(TestHinge(), theta), by_entry.b);
    for (int k = 0; k < kBendEntries; ++k) sum += by_entry.entries()[k] * table.entries()[k];
    EXPECT_NEAR(sum, HingeStiffness(law, TestHinge(), table, theta), 1e-12 * sum);
  }
}

TYPED_TEST(BendTest, FloatAgreesTo1em5) {
  for (double theta = -1.5; theta < 1.6; theta += 0.11) {
    double dense[kBendCols] = {}, dense_float[kBendCols] = {};
    const auto columns = TypeParam::Columns(TestHinge(), theta);
    const auto columns_float = TypeParam::Columns(TestHinge(), static_cast<float>(theta));
    for (int i = 0; i < TypeParam::kColumns; ++i) {
      dense[columns.column[i]] += columns.weight[i];
      dense_float[columns_float.column[i]] += columns_float.weight[i];
    }
    for (int c = 0; c < kBendCols; ++c) EXPECT_NEAR(dense_float[c], dense[c], 1e-5);
  }
}

TYPED_TEST(BendTest, WeightsArePositiveSumToOneAndReachTheirColumns) {
  const Hinge hinge = TestHinge();
  for (int column = 0; column < kBendCols; ++column) {
    // Past its last knot the law stays on column 4; at columns 1..3 their own weight is the
    // largest.
    const double theta = column < kBendCols - 1 ? column * 0.9 * 0.1 : 3.0;
    const auto w = TypeParam::Columns(hinge, theta);
    double sum = 0.0;
    for (double weight : w.weight) {
      EXPECT_GE(weight, 0.0);
      sum += weight;
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
  }
}

TYPED_TEST(BendTest, MeasureIsOddRisesAndHasItsDerivatives) {
  constexpr double kStep = 1e-5;
  for (double theta = -3.0; theta <= 3.0; theta += 0.5) {
    const HingeMeasure low = TypeParam::Measure(theta - kStep), at = TypeParam::Measure(theta),
                       high = TypeParam::Measure(theta + kStep);
    EXPECT_EQ(at.value, -TypeParam::Measure(-theta).value);
    EXPECT_GE(at.slope, 1.0);
    EXPECT_NEAR((high.value - low.value) / (2 * kStep), at.slope, 1e-9);
    EXPECT_NEAR((high.slope - low.slope) / (2 * kStep), at.curvature, 1e-9);
  }
}

// The smooth law's measure is that of discrete rods, 2·tan(θ/2)/cos²(θ/2), to fourth order.
TEST(SmoothBendTest, SmallAnglesAreMeasuredByTheirTangent) {
  for (const double theta : {0.05, 0.1, 0.2}) {
    const double t = std::tan(theta / 2);
    EXPECT_NEAR(SmoothBend::Measure(theta).value, 2 * t * (1 + t * t), 0.2 * std::pow(theta, 5));
  }
  EXPECT_EQ(ReferenceBend::Measure(0.2).value, 0.2);
}

TEST(SmoothBendTest, RidgeAndValleyAreAlike) {
  const BendTable table = test::TestMaterial().bend[0];
  for (double theta = 0.05; theta < 3.0; theta += 0.1) {
    EXPECT_EQ(HingeStiffness(SmoothBend(), TestHinge(), table, theta),
              HingeStiffness(SmoothBend(), TestHinge(), table, -theta));
    EXPECT_EQ(BendEnergy(SmoothBend(), TestHinge(), table, theta),
              BendEnergy(SmoothBend(), TestHinge(), table, -theta));
  }
  // The reference law puts every ridge in column 0 [MODEL, M19].
  EXPECT_NE(HingeStiffness(ReferenceBend(), TestHinge(), table, 0.3),
            HingeStiffness(ReferenceBend(), TestHinge(), table, -0.3));
}
}  // namespace
}  // namespace drape
