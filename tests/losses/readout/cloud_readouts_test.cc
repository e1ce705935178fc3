// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/cloud_readouts.h"

#include <gtest/gtest.h>

#include <numeric>

#include "physics/cloth/contact/pairs/contact_pair.h"
#include "tests/losses/disc.h"
#include "tests/losses/readout/differences.h"

namespace drape {
namespace {

using Eigen::Vector3d;

class CloudReadoutsTest : public testing::Test {
 protected:
  Vector3d Corner(int face, int k) const { return x_.segment<3>(3 * mesh_.faces[face].vertex[k]); }
  // Places inside faces, moved along their normals.
  Eigen::VectorXd PointsNearFaces(double distance) const {
    Eigen::VectorXd points(3 * (mesh_.num_faces() / 5));
    for (int i = 0; i < points.size() / 3; ++i) {
      const Vector3d a = Corner(5 * i, 0), b = Corner(5 * i, 1), c = Corner(5 * i, 2);
      points.segment<3>(3 * i) =
          0.3 * a + 0.45 * b + 0.25 * c + distance * (b - a).cross(c - a).normalized();
    }
    return points;
  }
  // Places 2 cm outside the hem: before its vertices and before the middles of its edges.
  Eigen::VectorXd PointsBeforeHem() const {
    const std::vector<int>& hem = mesh_.boundary_loops[0];
    Eigen::VectorXd points(6 * hem.size());
    for (size_t i = 0; i < hem.size(); ++i) {
      const Vector3d here = x_.segment<3>(3 * hem[i]),
                     next = x_.segment<3>(3 * hem[(i + 1) % hem.size()]);
      const Vector3d middle = 0.5 * (here + next);
      points.segment<3>(6 * i) = here * (1 + 0.02 / here.norm());
      points.segment<3>(6 * i + 3) = middle * (1 + 0.02 / middle.norm());
    }
    return points;
  }

  const Mesh mesh_ = MakeDisc(5, 50, 0.15);
  const Eigen::VectorXd x_ =
      Deform(mesh_, {.folds = 5, .twist = 0.4}) + 1e-3 * RandomVector(3 * mesh_.num_vertices(), 6);
};

TEST_F(CloudReadoutsTest, OffsetsFromAFlatSheet) {
  const Eigen::VectorXd points = (Eigen::VectorXd(9) << 0.031, 0.05, 0.02,  // above a face
                                  0.17, 0.0, 0.01,                          // outside a corner
                                  0.05, -0.02, -0.03)                       // below
                                     .finished();
  const PointCloudReadout readout(mesh_, points);
  ASSERT_EQ(readout.size(), 9);
  EXPECT_EQ(readout.group(), 3);
  Eigen::VectorXd r;
  ASSERT_TRUE(readout.Read(mesh_.rest_x, &r, nullptr));
  const Eigen::VectorXd expected =
      (Eigen::VectorXd(9) << 0, 0, 0.02, 0.02, 0, 0.01, 0, 0, -0.03).finished();
  EXPECT_LT((r - expected).norm(), 1e-15);
}

TEST_F(CloudReadoutsTest, OffsetHasTheDerivativeOfDifferences) {
  for (const double distance : {0.0, 1e-9, 0.003, -0.003})
    test::ExpectDerivative(PointCloudReadout(mesh_, PointsNearFaces(distance)), x_, 1e-6, 1e-7);
  test::ExpectDerivative(PointCloudReadout(mesh_, PointsBeforeHem()), x_, 1e-6, 1e-7);
}

TEST_F(CloudReadoutsTest, OffsetIsFromTheClosestPlace) {
  const Eigen::VectorXd points = 0.12 * RandomVector(150, 5);
  Eigen::VectorXd r;
  ASSERT_TRUE(PointCloudReadout(mesh_, points).Read(x_, &r, nullptr));
  for (int i = 0; i < 50; ++i) {
    const Vector3d p = points.segment<3>(3 * i);
    double least = HUGE_VAL;
    for (int f = 0; f < mesh_.num_faces(); ++f) {
      const Vector3d w = NearestWeights(p, Corner(f, 0), Corner(f, 1), Corner(f, 2));
      const Vector3d q = w[0] * Corner(f, 0) + w[1] * Corner(f, 1) + w[2] * Corner(f, 2);
      least = std::min(least, (p - q).norm());
    }
    EXPECT_NEAR(r.segment<3>(3 * i).norm(), least, 1e-14);
  }
}

TEST_F(CloudReadoutsTest, OffsetCannotBeReadOfWhatIsNotFiniteOrHasNoArea) {
  const PointCloudReadout readout(mesh_, PointsNearFaces(0.0));
  Eigen::VectorXd r, x = x_;
  x[8] = std::nan("");
  EXPECT_FALSE(readout.Read(x, &r, nullptr));
  x = x_;
  x.segment<3>(3) = x.head<3>();
  EXPECT_FALSE(readout.Read(x, &r, nullptr));
}

TEST_F(CloudReadoutsTest, UncoveredIsTheDistanceBetweenItsBounds) {
  const Eigen::VectorXd point = Vector3d(0.15, 0.0, 0.04);
  std::vector<int> vertices = {201, 0, 226};  // 4, 15.5 and 30.3 cm from the point
  const UncoveredReadout readout(point, vertices, {.spacing = 0.01, .max_distance = 0.2});
  ASSERT_EQ(readout.size(), 3);
  EXPECT_EQ(readout.group(), 1);
  Eigen::VectorXd r;
  ReadoutJacobian jacobian;
  ASSERT_TRUE(readout.Read(mesh_.rest_x, &r, &jacobian));
  EXPECT_NEAR(r[0], 0.03, 1e-15);
  EXPECT_NEAR(r[1], std::hypot(0.15, 0.04) - 0.01, 1e-15);
  EXPECT_NEAR(r[2], 0.19, 1e-15);
  EXPECT_EQ(jacobian.row(2).norm(), 0.0);
  test::ExpectDerivative(readout, mesh_.rest_x);
  Eigen::VectorXd x = mesh_.rest_x;
  x.segment<3>(603) = point + Vector3d(0.004, 0.0, 0.0);
  ASSERT_TRUE(readout.Read(x, &r, &jacobian));
  EXPECT_EQ(r[0], 0.0);
  EXPECT_EQ(jacobian.row(0).norm(), 0.0);
  x[5] = std::nan("");
  EXPECT_FALSE(readout.Read(x, &r, nullptr));
}

TEST_F(CloudReadoutsTest, UncoveredHasTheDerivativeOfDifferences) {
  std::vector<int> vertices(mesh_.num_vertices());
  std::iota(vertices.begin(), vertices.end(), 0);
  test::ExpectDerivative(UncoveredReadout(PointsNearFaces(0.003), vertices, {}), x_, 1e-6, 1e-7);
}

}  // namespace
}  // namespace drape
