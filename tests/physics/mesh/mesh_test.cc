// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "physics/mesh/disc.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Triangles = std::vector<std::array<int, 3>>;

// The corners of two squares in two rows, 0 1 2 and 3 4 5, 0.1 m apart.
Eigen::Matrix2Xd SixPoints() {
  Eigen::Matrix2Xd uv(2, 6);
  uv << 0, .1, .2, 0, .1, .2,  //
      0, 0, 0, .1, .1, .1;
  return uv;
}

Eigen::VectorXd Flat(const Eigen::Matrix2Xd& uv) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * uv.cols());
  for (int i = 0; i < uv.cols(); ++i) x.segment<2>(3 * i) = uv.col(i);
  return x;
}

Mesh Build(const Triangles& triangles, const Eigen::Matrix2Xd& uv = SixPoints()) {
  return BuildMesh(Flat(uv), uv, triangles, "cloth");
}

const Triangles kStrip = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};

TEST(Mesh, ListsTheTrianglesItWasBuiltFrom) { EXPECT_EQ(ListTriangles(Build(kStrip)), kStrip); }

TEST(BuildMesh, GivesAreasAndInverseRestShape) {
  const Mesh mesh = Build(kStrip);
  ASSERT_EQ(mesh.num_faces(), 4);
  for (const Face& face : mesh.faces) {
    EXPECT_DOUBLE_EQ(face.area, .005);
    Eigen::Matrix2d rest, inverse;
    for (int k = 0; k < 2; ++k) {
      rest.col(k) = mesh.uv.col(face.vertex[k + 1]) - mesh.uv.col(face.vertex[0]);
      inverse.row(k) << face.inverse_rest[2 * k], face.inverse_rest[2 * k + 1];
    }
    EXPECT_LT((rest * inverse - Eigen::Matrix2d::Identity()).norm(), 1e-14);
  }
}

TEST(BuildMesh, OrdersHingesAsFacesMeetThem) {
  const Mesh mesh = Build(kStrip);
  ASSERT_EQ(mesh.num_hinges(), 3);
  EXPECT_THAT(mesh.hinges[0].vertex, ElementsAre(1, 4, 0, 5));
  EXPECT_THAT(mesh.hinges[0].face, ElementsAre(0, 3));
  EXPECT_THAT(mesh.hinges[1].vertex, ElementsAre(4, 0, 1, 3));
  EXPECT_THAT(mesh.hinges[1].face, ElementsAre(0, 1));
  EXPECT_THAT(mesh.hinges[2].vertex, ElementsAre(5, 1, 2, 4));
  EXPECT_THAT(mesh.hinges[2].face, ElementsAre(2, 3));
}

TEST(BuildMesh, GivesHingeLengthAreaAndDirection) {
  const Mesh mesh = Build(kStrip);
  EXPECT_DOUBLE_EQ(mesh.hinges[0].rest_length, .1);
  EXPECT_DOUBLE_EQ(mesh.hinges[1].rest_length, .1 * std::numbers::sqrt2);
  EXPECT_DOUBLE_EQ(mesh.hinges[0].rest_area, .01);
  EXPECT_DOUBLE_EQ(mesh.hinges[0].direction, 2);  // along the warp
  EXPECT_DOUBLE_EQ(mesh.hinges[1].direction, 1);  // 45°, traversed towards -u -v
}

TEST(BuildMesh, FoldsEdgeDirectionsAtNinetyDegrees) {
  for (const double degrees : {0., 20., 80., 100., 160., 180., 200., 260., 280., 340.}) {
    const double angle = degrees * std::numbers::pi / 180;
    Eigen::Matrix2Xd uv(2, 4);
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
    uv << Eigen::Vector2d::Zero(), along, across, -across;
    const Mesh mesh = Build({{0, 1, 2}, {1, 0, 3}}, uv);
    const double to_weft = std::fmod(degrees, 180);
    const double expected = (to_weft > 90 ? 180 - to_weft : to_weft) / 45;
    EXPECT_NEAR(mesh.hinges[0].direction, expected, 1e-12) << degrees;
  }
}

TEST(BuildMesh, WalksTheBoundaryWithTheClothOnTheLeft) {
  const Mesh mesh = Build(kStrip);
  ASSERT_EQ(mesh.boundary_loops.size(), 1u);
  EXPECT_THAT(mesh.boundary_loops[0], ElementsAre(0, 1, 2, 5, 4, 3));
}

TEST(BuildMesh, PutsTheLongestBoundaryFirst) {  // a square with a square hole
  Eigen::Matrix2Xd uv(2, 8);
  uv << 1, 2, 2, 1, 0, 3, 3, 0,  //
      1, 1, 2, 2, 0, 0, 3, 3;
  const Mesh mesh = Build(
      {{4, 5, 0}, {5, 1, 0}, {5, 6, 1}, {6, 2, 1}, {6, 7, 2}, {7, 3, 2}, {7, 4, 3}, {4, 0, 3}}, uv);
  ASSERT_EQ(mesh.boundary_loops.size(), 2u);
  EXPECT_THAT(mesh.boundary_loops[0], ElementsAre(4, 5, 6, 7));
  EXPECT_THAT(mesh.boundary_loops[1], ElementsAre(0, 3, 2, 1));
}

void ExpectError(const Triangles& triangles, const Eigen::Matrix2Xd& uv, const char* message) {
  EXPECT_INPUT_ERROR(Build(triangles, uv), message);
}

TEST(BuildMesh, RejectsBadFaces) {
  const Eigen::Matrix2Xd uv = SixPoints();
  ExpectError({}, uv, "cloth: the mesh has no faces");
  ExpectError({{0, 1, 4}, {0, 4, 6}}, uv,
              "cloth: face 2: vertex index 7 is out of range, expected 1..6");
  ExpectError({{0, 1, -1}}, uv, "cloth: face 1: vertex index 0 is out of range");
  ExpectError({{0, 1, 1}}, uv, "cloth: face 1: a corner is repeated");
  ExpectError({{0, 1, 4}, {1, 4, 0}}, uv, "cloth: face 2: the same three vertices");
  ExpectError({{0, 1, 4}, {0, 4, 3}}, uv, "cloth: vertex 3 belongs to no face");
  ExpectError({{0, 1, 2}, {3, 4, 5}}, uv, "cloth: face 1: UV area is 0 m²");
  ExpectError({{0, 1, 4}, {0, 3, 4}, {1, 2, 5}}, uv, "cloth: face 2: UV area is -0.005 m²");
}

TEST(BuildMesh, RejectsBadTopology) {
  Eigen::Matrix2Xd uv(2, 5);
  uv << 0, 1, .5, .4, .3,  //
      0, 0, 1, 1.5, -1;
  ExpectError({{0, 1, 2}, {1, 0, 4}, {0, 1, 3}}, uv,
              "cloth: face 3: edge 1-2 has more than two faces");
  ExpectError({{0, 1, 2}, {0, 1, 3}, {1, 0, 4}}, uv,
              "cloth: face 2: edge 1-2 runs the same way as in face 1");
  Eigen::Matrix2Xd bow(2, 5);
  bow << 0, -1, -1, 1, 1,  //
      0, 1, -1, -1, 1;
  ExpectError({{0, 1, 2}, {0, 3, 4}}, bow, "cloth: vertex 1: two boundaries touch here");
}

TEST(BuildMesh, RejectsCoordinatesThatAreNotFinite) {
  Eigen::Matrix2Xd uv = SixPoints();
  uv(1, 4) = std::numeric_limits<double>::quiet_NaN();
  ExpectError(kStrip, uv, "cloth: vertex 5: a coordinate is not finite");
  Eigen::VectorXd x = Flat(SixPoints());
  x[3 * 2 + 2] = std::numeric_limits<double>::infinity();
  EXPECT_INPUT_ERROR(BuildMesh(x, SixPoints(), kStrip, "cloth"),
                     "cloth: vertex 3: a coordinate is not finite");
}

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
