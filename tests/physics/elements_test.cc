// SPDX-License-Identifier: Apache-2.0
// The stretch and hinge kernels of both laws, element by element.
#include <gmock/gmock.h>

#include <Eigen/Dense>

#include "cloth_fixture.h"
#include "physics/assembly.h"
#include "physics/law.h"

namespace drape {
namespace {

using Columns = DeformationGradient<double>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Matrix12 = Eigen::Matrix<double, 12, 12, Eigen::RowMajor>;

template <class Laws>
class StretchTest : public testing::Test {};
using StretchLaws = testing::Types<ReferenceStretch, SmoothStretch>;
TYPED_TEST_SUITE(StretchTest, StretchLaws);

template <class Laws>
class BendTest : public testing::Test {};
using BendLaws = testing::Types<ReferenceBend, SmoothBend>;
TYPED_TEST_SUITE(BendTest, BendLaws);

Columns RandomColumns(double scale, std::mt19937_64& random) {
  Columns c;
  for (double& value : std::span(&c.u.x, 6)) value = scale * DrawNormal(random);
  return c;
}
// Near the flat rest state, strains of several per cent.
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

// Duals over F straight through the law, without the chain over the strains.
TYPED_TEST(StretchTest, DerivativeAgreesWithPlainAutomaticDifferentiation) {
  std::mt19937_64 random(2);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 50; ++i) {
    const Columns F = RandomF(random), w = RandomColumns(1.0, random);
    Matrix6 Q, expected;
    StretchStepDerivative(law, F, table, w, 0.05, reinterpret_cast<double(*)[6]>(Q.data()));
    DeformationGradient<Dual<6>> seeded;
    for (int j = 0; j < 6; ++j) (&seeded.u.x)[j] = Dual<6>((&F.u.x)[j], j);
    const auto g = StretchStepForce(EvaluateStretch(law, Green(seeded), table), seeded, w, 0.05);
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c) expected(r, c) = (&g.u.x)[r].v[c];
    EXPECT_LT((Q - expected).norm(), 1e-12 * expected.norm());
  }
}

// Central differences: the error falls with the square of the step until rounding (about 1e-16/step)
// or, for the reference law, a kink within the step takes over; the best of the sweep counts.
TYPED_TEST(StretchTest, DerivativeAgreesWithFiniteDifferences) {
  std::mt19937_64 random(3);
  const TypeParam law;
  const StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 20; ++i) {
    const Columns F = RandomF(random), w = RandomColumns(1.0, random);
    Matrix6 Q;
    StretchStepDerivative(law, F, table, w, 0.05, reinterpret_cast<double(*)[6]>(Q.data()));
    double best = 1.0;
    for (double step = 1e-3; step > 1e-8; step /= 10) {
      Matrix6 differences;
      for (int j = 0; j < 6; ++j) {
        Columns up = F, down = F;
        (&up.u.x)[j] += step;
        (&down.u.x)[j] -= step;
        differences.col(j) = (StepForce(law, up, table, w, 0.05) -
                              StepForce(law, down, table, w, 0.05)) / (2 * step);
      }
      best = std::min(best, (Q - differences).norm() / Q.norm());
    }
    EXPECT_LT(best, 1e-8);
  }
}

TYPED_TEST(StretchTest, StepMatrixIsSymmetricAndPositive) {
  std::mt19937_64 random(4);
  const TypeParam law;
  StretchTable table = test::TestMaterial().stretch[0];
  for (int i = 0; i < 50; ++i) {
    const Columns F = RandomF(random);
    const auto k = EvaluateStretch(law, Green(F), table);
    Matrix6 H;
    for (int j = 0; j < 6; ++j) {
      Columns unit{};
      (&unit.u.x)[j] = 1.0;
      const Columns column = StretchStiffnessTimes(k, F, unit);
      H.col(j) = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(&column.u.x);
    }
    EXPECT_LT((H - H.transpose()).norm(), 1e-14 * H.norm());
    const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(H);
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

// SPEC section 7: the cloth turned by 90° with its table turned back pulls the same. At a shear
// beyond the first strain cell: there the reference grid prefers weft (fact 2: 0° if i ≥ j).
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
    law.Stiffness(G, table, c);
    law.StiffnessByTable(G, table, by_entry);
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
  ReferenceStretch().Stiffness(G, table, c);
  ReferenceStretch().StiffnessByTable(G, table, by_entry);
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
                                                  size * std::sin(angle)}, table, c);
    for (int m = 0; m < kStretchCols; ++m) EXPECT_NEAR(c[m], at_rest[m], 1e-5 * at_rest[0]);
  }
}

// ---- hinges

Hinge TestHinge() {
  Hinge hinge{};
  hinge.rest_length = 0.01;
  hinge.rest_area = 9e-5;
  hinge.direction = 0.7;
  return hinge;
}
HingeCorners RandomHinge(std::mt19937_64& random) {
  HingeCorners c{{{0, 0, 0}, {0.01, 0, 0}, {0.006, 0.009, 0}, {0.004, -0.009, 0}}};
  for (double& value : std::span(&c.x[0].x, 12)) value += 3e-3 * DrawNormal(random);
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
        differences[i] = std::remainder(DihedralAngle(Moved(c, i, step)) -
                                            DihedralAngle(Moved(c, i, -step)), 2 * M_PI) / (2 * step);
      best = std::min(best, (differences - d).norm() / d.norm());
    }
    EXPECT_LT(best, 1e-7);
  }
}

// ∂θ/∂x in duals over all twelve coordinates, from the same wings.
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
    Matrix12 H, expected;
    AngleHessian(EvaluateWings(c), reinterpret_cast<double(*)[12]>(H.data()));
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j) expected(i, j) = (&gradient[i / 3].x)[i % 3].v[j];
    EXPECT_LT((H - expected).norm(), 1e-12 * expected.norm());
    EXPECT_LT((H - H.transpose()).norm(), 1e-11 * H.norm());
  }
}

template <class Law>
Eigen::Matrix<double, 12, 1> StepForce(const Law& law, const HingeCorners& x, const HingeCorners& w,
                                       double h) {
  const HingeGradient d = AngleGradient(EvaluateWings(x));
  const double theta = DihedralAngle(x);
  const double kappa = HingeStiffness(law, TestHinge(), test::TestMaterial().bend[0], theta);
  return -StepMoment(kappa, theta, Dot(d, w), h) *
         Eigen::Map<const Eigen::Matrix<double, 12, 1>>(&d.d[0].x);
}

TYPED_TEST(BendTest, DerivativeAgreesWithFiniteDifferences) {
  std::mt19937_64 random(10);
  const TypeParam law;
  for (int n = 0; n < 30; ++n) {
    const HingeCorners x = RandomHinge(random);
    HingeCorners w;
    for (double& value : std::span(&w.x[0].x, 12)) value = 0.1 * DrawNormal(random);
    Matrix12 Q;
    BendStepDerivative(law, TestHinge(), test::TestMaterial().bend[0], x, w, 0.05,
                       reinterpret_cast<double(*)[12]>(Q.data()));
    double best = 1.0;
    for (double step = 1e-5; step > 1e-10; step /= 10) {
      Matrix12 differences;
      for (int j = 0; j < 12; ++j)
        differences.col(j) = (StepForce(law, Moved(x, j, step), w, 0.05) -
                              StepForce(law, Moved(x, j, -step), w, 0.05)) / (2 * step);
      best = std::min(best, (Q - differences).norm() / Q.norm());
    }
    EXPECT_LT(best, 1e-6);
  }
}

TYPED_TEST(BendTest, MomentIsMinusTheDerivativeOfTheEnergy) {
  const TypeParam law;
  const BendTable table = test::TestMaterial().bend[0];
  const Hinge hinge = TestHinge();
  for (double theta = -2.9; theta < 3.0; theta += 0.0917) {
    const double step = 1e-5;
    const double slope = (BendEnergy(law, hinge, table, theta + step) -
                          BendEnergy(law, hinge, table, theta - step)) / (2 * step);
    const double moment = HingeStiffness(law, hinge, table, theta) * theta;
    EXPECT_NEAR(slope, moment, 1e-8 * HingeStiffness(law, hinge, table, M_PI)) << "theta " << theta;
  }
}

TYPED_TEST(BendTest, StiffnessByTableIsItsDerivative) {
  const TypeParam law;
  const BendTable table = test::TestMaterial().bend[0];
  for (double theta = -1.5; theta < 1.6; theta += 0.11) {
    double by_entry[kBendRows][kBendCols], sum = 0.0;
    HingeStiffnessByTable(law, TestHinge(), table, theta, by_entry);
    for (int k = 0; k < kBendEntries; ++k) sum += (&by_entry[0][0])[k] * (&table.b[0][0])[k];
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
    // Past its last knot the law stays on column 4; at columns 1..3 theirs is the heaviest.
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

TEST(SmoothBendTest, RidgeAndValleyAreAlike) {
  const BendTable table = test::TestMaterial().bend[0];
  for (double theta = 0.05; theta < 3.0; theta += 0.1) {
    EXPECT_EQ(HingeStiffness(SmoothBend(), TestHinge(), table, theta),
              HingeStiffness(SmoothBend(), TestHinge(), table, -theta));
    EXPECT_EQ(BendEnergy(SmoothBend(), TestHinge(), table, theta),
              BendEnergy(SmoothBend(), TestHinge(), table, -theta));
  }
  // The reference law puts every ridge in column 0 (SPEC section 3).
  EXPECT_NE(HingeStiffness(ReferenceBend(), TestHinge(), table, 0.3),
            HingeStiffness(ReferenceBend(), TestHinge(), table, -0.3));
}

// ---- the whole cloth

TEST(MirrorTest, TurningTheClothOverChangesNothingInTheSmoothLaw) {
  std::mt19937_64 random(11);
  for (const std::string law : {"smooth", "reference"}) {
    Scene scene;
    const ClothModel model(test::SmallDisc(law)->mesh, scene, MakeLaw(law));
    const Eigen::VectorXd x = test::NoisyStart(model, 3e-3, random).x;
    Eigen::VectorXd force, mirrored_force, mirrored_x = x;
    for (int i = 2; i < x.size(); i += 3) mirrored_x[i] = -x[i];
    AssembleForce(model, test::TestMaterial(), x, force);
    AssembleForce(model, test::TestMaterial(), mirrored_x, mirrored_force);
    for (int i = 2; i < x.size(); i += 3) mirrored_force[i] = -mirrored_force[i];
    const double difference = (force - mirrored_force).norm() / force.norm();
    if (law == "smooth") {
      EXPECT_LT(difference, 1e-12);
    } else {
      EXPECT_GT(difference, 1e-6);  // its known artefact
    }
  }
}

TEST(RigidMotionTest, NoForceAndNoTorque) {
  std::mt19937_64 random(12);
  for (const std::string law : {"smooth", "reference"}) {
    const ClothModel model(test::SmallDisc(law)->mesh, Scene(), MakeLaw(law));
    const MaterialField material = test::TestMaterial();
    const Eigen::AngleAxisd turn(1.1, Eigen::Vector3d(1, 2, -1).normalized());
    const auto rigid = [&](Eigen::VectorXd x) {
      for (int i = 0; i < x.size(); i += 3)
        x.segment<3>(i) = turn * x.segment<3>(i) + Eigen::Vector3d(0.3, -0.2, 0.7);
      return x;
    };
    // At rest: no force. The scale is that of a strain of 1 %.
    Eigen::VectorXd force, scale;
    AssembleForce(model, material, 1.01 * model.mesh.rest_x, scale);
    AssembleForce(model, material, rigid(model.mesh.rest_x), force);
    EXPECT_LT(force.norm(), 1e-10 * scale.norm());
    // Deformed: internal forces balance, and they turn with the cloth.
    const Eigen::VectorXd x = test::NoisyStart(model, 1e-3, random).x, turned = rigid(x);
    Eigen::VectorXd turned_force;
    AssembleForce(model, material, x, force);
    AssembleForce(model, material, turned, turned_force);
    Eigen::Vector3d total = Eigen::Vector3d::Zero(), torque = total;
    for (int i = 0; i < x.size(); i += 3) {
      total += turned_force.segment<3>(i);
      torque += turned.segment<3>(i).cross(turned_force.segment<3>(i));
      EXPECT_LT((turn * force.segment<3>(i) - turned_force.segment<3>(i)).norm(), 1e-10 * force.norm());
    }
    EXPECT_LT(total.norm(), 1e-10 * force.norm());
    EXPECT_LT(torque.norm(), 1e-10 * force.norm());
  }
}

TEST(AssemblyTest, HingePartOfTheStepMatrixHasRankOne) {
  DiscOptions options;
  options.target_vertices = 100;
  Mesh mesh = MakeDisc(options);
  mesh.hinges.resize(1);
  Scene scene;
  scene.stretch = false;
  const ClothModel model(mesh, scene, MakeLaw("smooth"));
  MaterialField material = test::TestMaterial();
  material.density = 0.0;
  std::mt19937_64 random(13);
  Eigen::VectorXd force;
  BlockMatrix A(model.pattern);
  AssembleStep(model, material, test::NoisyStart(model, 3e-3, random).x, 0.05, force, A);
  const int n = model.num_dofs();
  RowMatrix dense = RowMatrix::Zero(n, n);
  AddMultiply(model.pattern, A, RowMatrix::Identity(n, n), dense);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(dense);
  EXPECT_LT((dense - dense.transpose()).norm(), 1e-14 * dense.norm());
  EXPECT_GT(eigen.eigenvalues()[n - 1], 0.0);
  EXPECT_LT(std::fabs(eigen.eigenvalues()[n - 2]), 1e-12 * eigen.eigenvalues()[n - 1]);
  EXPECT_GT(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues()[n - 1]);
}

}  // namespace
}  // namespace drape
