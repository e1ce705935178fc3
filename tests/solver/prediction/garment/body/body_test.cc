// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/body.h"

#include <gmock/gmock.h>

#include <array>
#include <string>
#include <vector>

#include "physics/mesh/obj_io.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

class BodySequenceTest : public FileFixture {
 protected:
  using Triangles = std::vector<std::array<int, 3>>;

  // An octahedron of radius .5 about (0, 0, z), turned by an angle about z.
  void WriteFrame(int number, double z, double angle = 0) const {
    const double c = .5 * std::cos(angle), s = .5 * std::sin(angle);
    WriteVertices(number,
                  {{c, s, z}, {-s, c, z}, {-c, -s, z}, {s, -c, z}, {0, 0, z + .5}, {0, 0, z - .5}});
  }
  void WriteVertices(int number, const std::vector<Eigen::Vector3d>& vertices,
                     const Triangles& triangles = kFaces) const {
    ObjSurface surface{Eigen::VectorXd(3 * vertices.size()), triangles};
    for (std::size_t i = 0; i < vertices.size(); ++i) surface.x.segment<3>(3 * i) = vertices[i];
    WriteObj(Path("body_000" + std::to_string(number) + ".obj"), surface);
  }
  std::unique_ptr<Body> ReadAll(double frames_per_second = 10) const {
    return ReadBodySequence(Path("body_%04d.obj"), frames_per_second);
  }

  static const inline Triangles kFaces = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                                          {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
};

TEST_F(BodySequenceTest, MovesLinearlyBetweenFramesAndRestsAfterTheLast) {
  WriteFrame(1, 0);
  WriteFrame(2, .2);
  const auto body = ReadAll();
  EXPECT_EQ(body->num_vertices(), 6);
  EXPECT_EQ(body->triangles().size(), 8u);
  EXPECT_NEAR(body->Positions(0)[2], 0, 1e-12);
  EXPECT_NEAR(body->Positions(.025)[2], .05, 1e-12);
  EXPECT_NEAR(body->Positions(.1)[2], .2, 1e-12);
  EXPECT_NEAR(body->Positions(7)[2], .2, 1e-12);
}

TEST_F(BodySequenceTest, ThePelvisFollowsTheRigidMotion) {
  WriteFrame(0, 0);
  WriteFrame(1, .2, .3);
  const auto body = ReadAll();
  const Eigen::Vector3d moved = body->PelvisMotion(.1) * Eigen::Vector3d(.1, 0, .1);
  const Eigen::Vector3d expected(.1 * std::cos(.3), .1 * std::sin(.3), .3);
  EXPECT_LT((moved - expected).norm(), 1e-5);
}

TEST_F(BodySequenceTest, RefusesBadNamesAndNumbers) {
  EXPECT_INPUT_ERROR(ReadBodySequence("body.obj", 30), "expected a name with one number");
  EXPECT_INPUT_ERROR(ReadBodySequence("body_%s.obj", 30), "expected a name with one number");
  EXPECT_INPUT_ERROR(ReadBodySequence("%d_%d.obj", 30), "expected a name with one number");
  EXPECT_INPUT_ERROR(ReadAll(), "body_0001.obj");
  WriteFrame(0, 0);
  EXPECT_INPUT_ERROR(ReadAll(.5), "0.5 frames per second");
}

TEST_F(BodySequenceTest, RefusesAMissingNumber) {
  WriteFrame(0, 0);
  WriteFrame(1, .1);
  WriteFrame(4, .2);
  EXPECT_INPUT_ERROR(ReadAll(), "body_0002.obj: is missing, but ");
}

TEST_F(BodySequenceTest, RefusesSurfacesThatAreOpenInsideOutOrCrossing) {
  Triangles open = kFaces, doubled = kFaces;
  open.pop_back();
  doubled.push_back(kFaces.front());
  const std::vector<Eigen::Vector3d> corners = {{1, 0, 0},  {0, 1, 0}, {-1, 0, 0},
                                                {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  WriteVertices(0, corners, open);
  EXPECT_INPUT_ERROR(ReadAll(), "body_0000.obj: face 5: edge 1-6 has no second face");
  WriteVertices(0, corners, doubled);
  EXPECT_INPUT_ERROR(ReadAll(), "body_0000.obj: face 9: edge 1-2 runs as in another face");
  auto turned = corners;
  std::swap(turned[4], turned[5]);
  WriteVertices(0, turned);
  EXPECT_INPUT_ERROR(ReadAll(), "body_0000.obj: the volume is -1.33333 m³");
  auto crossing = corners;
  crossing[4] = {3, .1, -.5};
  WriteVertices(0, crossing);
  EXPECT_INPUT_ERROR(ReadAll(), "intersect near");
}

TEST_F(BodySequenceTest, RefusesFramesThatDiffer) {
  WriteFrame(0, 0);
  Triangles turned = kFaces;
  turned.front() = {1, 4, 0};
  WriteVertices(1, {{.5, 0, 0}, {0, .5, 0}, {-.5, 0, 0}, {0, -.5, 0}, {0, 0, .5}, {0, 0, -.5}},
                turned);
  EXPECT_INPUT_ERROR(ReadAll(), "body_0001.obj: face 1 is 2 5 1, expected 1 2 5 as in ");
  WriteFrame(1, 3);
  EXPECT_INPUT_ERROR(ReadAll(),
                     "body_0001.obj: vertex 1 moves at 30 m/s, expected at most 20 m/s from ");
}

TEST_F(BodySequenceTest, IsOneOfTheBodiesThatAUserNames) {
  WriteFrame(0, 0);
  EXPECT_EQ(ParseBody(Path("body_%04d.obj"), kRestArmAngle)->num_vertices(), 6);
  EXPECT_GT(ParseBody("mannequin:turn", kRestArmAngle)->num_vertices(), 1000);
  EXPECT_INPUT_ERROR(ParseBody("mannequin:fly", kRestArmAngle),
                     "motion: found 'fly', expected one of stand, walk, turn, jump");
  EXPECT_INPUT_ERROR(ParseBody("mannequin", kRestArmAngle), "expected a name with one number");
}

}  // namespace
}  // namespace drape
