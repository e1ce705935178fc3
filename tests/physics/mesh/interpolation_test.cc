// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

class Interpolation : public testing::Test {
 protected:
  const Mesh disc_ = MakeDisc({.target_vertices = 1200});
};

TEST_F(Interpolation, WeightsAreExactForLinearFieldsInside) {
  std::mt19937_64 random(3);
  Eigen::Matrix2Xd points(2, 50);
  for (double& c : points.reshaped()) c = 0.04 * SampleNormal(random);
  const auto linear = [](const Eigen::Matrix2Xd& p) -> Eigen::VectorXd {
    return (Eigen::RowVector2d(2, -1) * p).transpose().array() + 0.5;
  };
  ASSERT_LT(points.colwise().norm().maxCoeff(), 0.14);
  const Eigen::VectorXd read = InterpolationWeights(disc_, points) * linear(disc_.uv);
  EXPECT_LT((read - linear(points)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST_F(Interpolation, WeightsGoOnLinearlyBeyondTheHemWhereAsked) {
  const auto linear = [](const Eigen::Matrix2Xd& p) -> Eigen::VectorXd {
    return (0.3 + 2.0 * p.row(0).array() - 5.0 * p.row(1).array()).transpose();
  };
  Eigen::Matrix2Xd points(2, 3);
  points << 0.01, 0.1505, -0.12, 0.02, 0.001, 0.0905;
  const Eigen::VectorXd read =
      InterpolationWeights(disc_, points, Extrapolation::kLinear) * linear(disc_.uv);
  EXPECT_LT((read - linear(points)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_F(Interpolation, WeightsTakeTheNearestTriangleOutside) {
  const Eigen::Matrix2Xd outside = Eigen::Vector2d(0.1505, 0.0);
  const Eigen::VectorXd read = InterpolationWeights(disc_, outside) * disc_.uv.row(0).transpose();
  EXPECT_NEAR(read[0], 0.15, 1e-3);
}

// A rotated and moved cloth is read as one, also where a finer mesh reaches past the hem.
TEST_F(Interpolation, PositionsAreExactForAnAffineShape) {
  const auto shape = [](const Mesh& mesh) {
    Eigen::Matrix<double, 3, 2> map;
    map << 0.6, -0.8, 0.0, 0.3, 0.8, 0.6;
    const Eigen::Matrix3Xd points = (map * mesh.uv).colwise() + Eigen::Vector3d(0.1, 0.2, -0.3);
    return Eigen::VectorXd(points.reshaped());
  };
  const Mesh fine = MakeDisc({.target_vertices = 2000});
  const auto weights = InterpolationWeights(disc_, fine.uv, Extrapolation::kLinear);
  EXPECT_LT((ReadPositions(weights, shape(disc_)) - shape(fine)).cwiseAbs().maxCoeff(), 1e-13);
}

}  // namespace
}  // namespace drape
