// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "solver/fit/fit.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

Eigen::MatrixXd Rotation(int size, std::mt19937_64& random) {
  const Eigen::MatrixXd noise = test::RandomMatrix(size, size, random);
  return Eigen::HouseholderQR<Eigen::MatrixXd>(noise).householderQ();
}

TEST(Spectrum, FindsValuesAndDirectionsOfAKnownJacobian) {
  std::mt19937_64 random(3);
  const Eigen::MatrixXd u = Rotation(6, random), v = Rotation(4, random);
  const Eigen::Vector4d values(20.0, 3.0, 0.8, 0.1);
  const Spectrum spectrum =
      ComputeSpectrum(u.leftCols(4) * values.asDiagonal() * v.transpose(), 1.0);
  EXPECT_LT((spectrum.values - values).norm(), 1e-12);
  EXPECT_EQ(spectrum.determined, 2);
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(std::fabs(spectrum.directions.col(i).dot(v.col(i))), 1.0, 1e-12) << i;
}

TEST(Spectrum, AWiderPriorLeavesMoreToTheData) {
  const Eigen::MatrixXd jacobian = Eigen::Vector3d(20.0, 3.0, 0.8).asDiagonal();
  EXPECT_EQ(ComputeSpectrum(jacobian, 0.1).determined, 1);
  EXPECT_EQ(ComputeSpectrum(jacobian, 1.0).determined, 2);
  EXPECT_EQ(ComputeSpectrum(jacobian, 10.0).determined, 3);
}

TEST(Spectrum, FewerResidualsThanParametersLeaveDirectionsUndetermined) {
  std::mt19937_64 random(4);
  const Eigen::MatrixXd jacobian = test::RandomMatrix(2, 5, random);
  const Spectrum spectrum = ComputeSpectrum(jacobian, 100.0);
  ASSERT_EQ(spectrum.values.size(), 5);
  EXPECT_GT(spectrum.values[1], 0.0);
  EXPECT_EQ(spectrum.values.tail(3), Eigen::Vector3d::Zero());
  EXPECT_EQ(spectrum.determined, 2);
  EXPECT_LT((jacobian * spectrum.directions.rightCols(3)).norm(), 1e-13);
  const Eigen::MatrixXd gram = spectrum.directions.transpose() * spectrum.directions;
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(5, 5)).norm(), 1e-13);
}

}  // namespace
}  // namespace drape
