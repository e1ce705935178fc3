// SPDX-License-Identifier: Apache-2.0
// Tests of the simpler forms of tables.
#include "physics/material/material_scaling.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "physics/cloth/assembly/assembly.h"
#include "physics/util/errors.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// The energy of a flat cloth under an in-plane stretch whose first axis lies at `angle` to the
// weft, in a scene without gravity.
double PlaneEnergy(const MaterialField& material, double major, double minor, double angle) {
  const auto mesh = test::SmallDisc("smooth", 100)->mesh;
  const ClothModel model(mesh, Scene(), MakeLaw("smooth"));
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
  const Eigen::Matrix2d stretch =
      turn * Eigen::Vector2d(1 + major, 1 + minor).asDiagonal() * turn.transpose();
  Eigen::VectorXd x = model.mesh.rest_x;
  for (int i = 0; i < model.mesh.num_vertices(); ++i)
    x.segment<2>(3 * i) = stretch * x.segment<2>(3 * i);
  return Energy(model, material, x);
}

TEST(TableForm, AnIsotropicTableHasNoDirection) {
  const MaterialField given = test::TestMaterial();
  const MaterialField isotropic = InForm(given, TableForm::kIsotropic);
  const double along = PlaneEnergy(isotropic, 0.06, 0.02, 0.0);
  ASSERT_GT(along, 0.0);
  for (const double angle : {0.3, 0.8, 1.3}) {
    EXPECT_NEAR(PlaneEnergy(isotropic, 0.06, 0.02, angle), along, 1e-9 * along) << angle;
    EXPECT_GT(std::abs(PlaneEnergy(given, 0.06, 0.02, angle) - PlaneEnergy(given, 0.06, 0.02, 0)),
              1e-3 * along);
  }
  for (const auto& row : isotropic.bend[0].b)
    for (const double entry : row) EXPECT_EQ(entry, isotropic.bend[0].b[0][0]);
}

TEST(TableForm, ALinearTableKeepsMeansAndDirections) {
  const MaterialField given = test::TestMaterial();
  const MaterialField linear = InForm(given, TableForm::kLinear);
  double sum = 0.0;
  for (const auto& row : given.stretch[0].c) sum += row[2];
  for (const auto& row : linear.stretch[0].c) EXPECT_NEAR(row[2], sum / kStretchRows, 1e-12);
  EXPECT_NE(linear.bend[0].b[0][0], linear.bend[0].b[2][0]);
  EXPECT_EQ(linear.bend[0].b[2][0], linear.bend[0].b[2][4]);
  EXPECT_EQ(linear.density, given.density);
}

TEST(TableForm, NamesReadBack) {
  for (const TableForm form : {TableForm::kGiven, TableForm::kLinear, TableForm::kIsotropic})
    EXPECT_EQ(ParseName<TableForm>(ToString(form), ""), form);
  EXPECT_THROW(ParseName<TableForm>("cubic", ""), InputError);
}

TEST(LaboratoryStiffness, AveragesWarpAndWeft) {
  EXPECT_DOUBLE_EQ(OverallStiffness(4.0, 9.0), 6.0);
}

// 1 gf·cm²/cm = 98.07 µN·m, 1 gf/(cm·°) = 56.19 N/m.
TEST(LaboratoryStiffness, ConvertsToKes) {
  EXPECT_NEAR(KesBending(98.07e-6), 1.0, 1e-4);
  EXPECT_NEAR(KesShear(56.19), 1.0, 1e-4);
  EXPECT_NEAR(ExtensionPercent(kKesForce, 4903.325), 10.0, 1e-12);
}

TEST(LaboratoryStiffness, FollowsFast) {
  EXPECT_NEAR(ExtensionPercent(kFastForces[2], 980.665), 10.0, 1e-12);
  EXPECT_DOUBLE_EQ(FastBiasExtensionPercent(41.0), 3.0);
  EXPECT_NEAR(FormabilityMm2(7.35e-6, 0.5, 2.5), 1.0, 1e-12);
}

}  // namespace
}  // namespace drape
