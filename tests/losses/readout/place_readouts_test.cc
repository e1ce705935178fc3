// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/place_readouts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/losses/disc.h"
#include "tests/losses/readout/differences.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using Eigen::Vector3d;

Mesh BuildDisc(int rings, int sectors) {
  const Mesh disc = MakeDisc(rings, sectors, 0.15);
  return BuildMesh(disc.rest_x, disc.uv, ListTriangles(disc), "disc");
}

const Eigen::Matrix2Xd kPlaces = (Eigen::Matrix2Xd(2, 4) << 0.0, 0.031, -0.08, 0.149,  //
                                  0.0, 0.052, 0.02, 0.0)
                                     .finished();

// A marker moves with the cloth in the same way on every mesh.
TEST(MarkerReadoutTest, ReadsTheSamePlacesOnEveryMesh) {
  Eigen::Matrix<double, 3, 2> by_material;
  by_material << 0.9, 0.1, -0.2, 0.8, 0.3, -0.5;
  for (const Mesh& mesh : {BuildDisc(5, 50), BuildDisc(7, 24)}) {
    Eigen::VectorXd x(3 * mesh.num_vertices());
    for (int i = 0; i < mesh.num_vertices(); ++i)
      x.segment<3>(3 * i) = by_material * mesh.uv.col(i) + Vector3d(0.1, 0.2, 0.3);
    const MarkerReadout readout(WeightsOfPlaces(mesh, kPlaces, "markers"));
    ASSERT_EQ(readout.size(), 12);
    EXPECT_EQ(readout.group(), 3);
    Eigen::VectorXd r;
    ASSERT_TRUE(readout.Read(x, &r, nullptr));
    for (int i = 0; i < 4; ++i) {
      const Vector3d expected = by_material * kPlaces.col(i) + Vector3d(0.1, 0.2, 0.3);
      EXPECT_LT((r.segment<3>(3 * i) - expected).norm(), 1e-15);
    }
    test::ExpectDerivative(readout, x);
    x[7] = std::nan("");
    EXPECT_FALSE(readout.Read(x, &r, nullptr));
  }
}

TEST(MarkerReadoutTest, ReadsVertices) {
  const Mesh mesh = BuildDisc(3, 12);
  const Eigen::VectorXd x = RandomVector(3 * mesh.num_vertices(), 4);
  Eigen::VectorXd r;
  ASSERT_TRUE(MarkerReadout(WeightsOfVertices(mesh, {7, 0}, "m")).Read(x, &r, nullptr));
  EXPECT_EQ(r.head<3>(), x.segment<3>(21));
  EXPECT_EQ(r.tail<3>(), x.head<3>());
  EXPECT_INPUT_ERROR(WeightsOfVertices(mesh, {0, 37}, "m.csv"),
                     "m.csv: place 2 is vertex 37, expected 0 … 36");
  EXPECT_INPUT_ERROR(WeightsOfVertices(mesh, {-1}, "m.csv"), "vertex -1");
}

TEST(MarkerReadoutTest, RefusesAPlaceOffTheClothButNotOneThatTheMeshCutsOff) {
  const Mesh mesh = BuildDisc(5, 24);
  const double angle = M_PI / 24;  // in the middle of an edge of the hem
  EXPECT_NO_THROW(WeightsOfPlaces(mesh, 0.15 * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                                  "markers.csv"));
  Eigen::Matrix2Xd places = kPlaces;
  places.col(2) << 0.1, 0.12;
  EXPECT_INPUT_ERROR(WeightsOfPlaces(mesh, places, "markers.csv"),
                     "markers.csv: place 3 at weft 0.1 m, warp 0.12 m is off the cloth");
  places(0, 2) = std::nan("");
  EXPECT_INPUT_ERROR(WeightsOfPlaces(mesh, places, "markers.csv"), "place 3");
}

TEST(PositionReadoutTest, IsAMarkerAtEachVertex) {
  const Mesh mesh = BuildDisc(2, 8);
  const PositionReadout readout(mesh);
  EXPECT_EQ(readout.size(), 51);
  EXPECT_EQ(readout.group(), 3);
  test::ExpectDerivative(readout, mesh.rest_x);
}

class TipTest : public testing::Test {
 protected:
  TipTest() {
    // A chord of 8 cm from the clamp at (3, 5, 1) cm, 30° below the horizontal, in the plane of a
    // direction 60° from x. The vertices of the tip lie across it.
    tip_ = clamp_ + 0.08 * (std::cos(M_PI / 6) * along_ - 0.5 * Vector3d::UnitZ());
    const Vector3d across(-along_.y(), along_.x(), 0.2);
    x_.segment<3>(3) = tip_ + 0.01 * across;
    x_.segment<3>(9) = tip_ - 0.01 * across;
  }
  const Vector3d along_{0.5, std::sqrt(0.75), 0.0}, clamp_{0.03, 0.05, 0.01};
  Vector3d tip_;
  Eigen::VectorXd x_ = RandomVector(12, 2);
};

TEST_F(TipTest, AngleIsThatOfTheChordBelowTheHorizontal) {
  const AngleReadout readout({1, 3}, clamp_, along_);
  Eigen::VectorXd r;
  ASSERT_TRUE(readout.Read(x_, &r, nullptr));
  EXPECT_NEAR(r[0], 30.0, 1e-12);
  test::ExpectDerivative(readout, x_);
  x_[4] = std::nan("");
  EXPECT_FALSE(readout.Read(x_, &r, nullptr));
  x_.segment<3>(3) = x_.segment<3>(9) = clamp_;
  EXPECT_FALSE(readout.Read(x_, &r, nullptr));
}

TEST_F(TipTest, StretchIsThePlaceOfTheTipByTheRestLength) {
  const TipReadout readout({1, 3}, along_, 0.05);
  Eigen::VectorXd r;
  ASSERT_TRUE(readout.Read(x_, &r, nullptr));
  EXPECT_NEAR(r[0], along_.dot(tip_) / 0.05, 1e-13);
  test::ExpectDerivative(readout, x_);
  x_[10] = std::nan("");
  EXPECT_FALSE(readout.Read(x_, &r, nullptr));
}

}  // namespace
}  // namespace drape
