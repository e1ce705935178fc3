// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "solver/prediction/exchange/exchange_record.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/simulation/textbook/closed_forms.h"
#include "tests/solver/prediction/exchange/twill.h"

namespace drape {
namespace {

using test::kTwill;

void ExpectEqual(const LinearFabric& a, const LinearFabric& b) {
  EXPECT_NEAR(a.c11, b.c11, 1e-12 * b.c11);
  EXPECT_NEAR(a.c22, b.c22, 1e-12 * b.c22);
  EXPECT_NEAR(a.c12, b.c12, 1e-12 * b.c12);
  EXPECT_NEAR(a.shear, b.shear, 1e-12 * b.shear);
  EXPECT_NEAR(a.bend_weft, b.bend_weft, 1e-12 * b.bend_weft);
  EXPECT_NEAR(a.bend_warp, b.bend_warp, 1e-12 * b.bend_warp);
  EXPECT_NEAR(a.bend_bias, b.bend_bias, 1e-12 * b.bend_bias);
  EXPECT_EQ(a.density, b.density);
}

TEST(LinearFabric, TablesOfALinearMaterialAreThatMaterial) {
  for (const char* law : {"smooth", "reference"})
    ExpectEqual(LineariseAtRest(TablesFrom(kTwill), MakeLaw(law)), kTwill);
  const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(kMaterialEntries, 0.0, 1.0);
  ExpectEqual(LineariseInDrape(TablesFrom(kTwill), MakeLaw("smooth"), weights), kTwill);
}

// The strip's formula for a sheet that has its rigidity along one direction.
TEST(LinearFabric, DirectionsAreThoseOfALaboratory) {
  LinearFabric material = kTwill;
  material.bend_weft = 5e-5;
  const BendTable bend = TablesFrom(material).bend[0];
  EXPECT_GT(DirectionalRigidity(bend, 0.0), 2.0 * DirectionalRigidity(bend, M_PI / 2));
}

// Of columns 10, 20, …: at zero the smooth law sees 3/4 of column 0 and 1/4 of column 1.
TEST(LinearFabric, RigidityIsThatOfTheCurvature) {
  MaterialField tables = TablesFrom(kTwill);
  for (int r = 0; r < kBendRows; ++r)
    for (int c = 0; c < kBendCols; ++c) tables.bend[0].b[r][c] = 4e-6 * (r + 1) * (c + 1);
  const LinearFabric rest = LineariseAtRest(tables, MakeLaw("smooth"));
  EXPECT_NEAR(rest.bend_warp, 1.25e-6, 1e-18);
  EXPECT_NEAR(rest.bend_bias, 2.50e-6, 1e-18);
  EXPECT_NEAR(rest.bend_weft, 3.75e-6, 1e-18);
  EXPECT_NEAR(LineariseAtRest(tables, MakeLaw("reference")).bend_weft, 3e-6, 1e-18);
  // All energy of row 2 in column 3, none in row 0.
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(kMaterialEntries);
  weights[kStretchEntries + 2 * kBendCols + 3] = 0.7;
  const LinearFabric drape = LineariseInDrape(tables, MakeLaw("smooth"), weights);
  EXPECT_NEAR(drape.bend_weft, 12e-6, 1e-18);
  EXPECT_EQ(drape.bend_warp, rest.bend_warp);
}

TEST(LinearFabric, IsotropicSheetsKeepWhatIsAsked) {
  const LinearFabric exact = WithIsotropicMembrane(kTwill, {.mu = 30.0, .lambda = 50.0});
  for (const IsotropicChoice choice :
       {IsotropicChoice::kNearest, IsotropicChoice::kShear, IsotropicChoice::kStretch}) {
    const IsotropicSheet sheet = MakeIsotropic(exact, choice);
    EXPECT_NEAR(sheet.mu, 30.0, 1e-12);
    EXPECT_NEAR(sheet.lambda, 50.0, 1e-12);
  }
  const LinearFabric shear =
      WithIsotropicMembrane(kTwill, MakeIsotropic(kTwill, IsotropicChoice::kShear));
  EXPECT_NEAR(shear.shear, kTwill.shear, 1e-12);
  EXPECT_NEAR(shear.c11, 260.0, 1e-12);
  const LinearFabric stretch =
      WithIsotropicMembrane(kTwill, MakeIsotropic(kTwill, IsotropicChoice::kStretch));
  EXPECT_NEAR(stretch.c12, kTwill.c12, 1e-12);
  EXPECT_NEAR(stretch.c11, 260.0, 1e-12);
  // The nearest has a smaller distance than its neighbours.
  const IsotropicSheet nearest = MakeIsotropic(kTwill, IsotropicChoice::kNearest);
  const auto distance = [](double mu, double lambda) {
    const LinearFabric m = WithIsotropicMembrane(kTwill, {mu, lambda});
    return std::pow(m.c11 - kTwill.c11, 2) + std::pow(m.c22 - kTwill.c22, 2) +
           2.0 * std::pow(m.c12 - kTwill.c12, 2) + 4.0 * std::pow(m.shear - kTwill.shear, 2);
  };
  for (const double d : {-0.1, 0.1}) {
    EXPECT_LT(distance(nearest.mu, nearest.lambda), distance(nearest.mu + d, nearest.lambda));
    EXPECT_LT(distance(nearest.mu, nearest.lambda), distance(nearest.mu, nearest.lambda + d));
  }
  LinearFabric stiff = kTwill;
  stiff.shear = 500.0;
  EXPECT_EQ(MakeIsotropic(stiff, IsotropicChoice::kNearest).lambda, 0.0);
}

TEST(LinearFabric, MeanRigidityIsThatOfAllDirections) {
  const BendTable bend = TablesFrom(kTwill).bend[0];
  double mean = 0.0;
  constexpr int kDirections = 360;
  for (int i = 0; i < kDirections; ++i)
    mean += DirectionalRigidity(bend, M_PI * i / kDirections) / kDirections;
  EXPECT_NEAR(MeanRigidity(kTwill), mean, 1e-4 * mean);
}

}  // namespace
}  // namespace drape
