// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/body.h"

#include <gmock/gmock.h>

#include <array>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "physics/mesh/obj_io.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

using Eigen::Vector3d;
using ::testing::IsEmpty;

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
  // Reads metres with z up and does not grow the body.
  std::unique_ptr<Body> ReadAll(double frames_per_second = 10) const {
    BodyFiles files = kAsItIs;
    files.frames_per_second = frames_per_second;
    return ReadBodySequence(Path("body_%04d.obj"), files);
  }

  static const inline BodyFiles kAsItIs = {
      .up = "z", .front = "-y", .scale = 1, .offset = {0, 0, 0}, .grow = false};

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
  EXPECT_EQ(body->num_files(), 2);
  EXPECT_NEAR(body->rests_after(), .1, 1e-12);
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
  EXPECT_INPUT_ERROR(ReadBodySequence("no_body.obj", {}), "no_body.obj");
  EXPECT_INPUT_ERROR(ReadBodySequence("body_%s.obj", {}), "or a name with one number");
  EXPECT_INPUT_ERROR(ReadBodySequence("%d_%d.obj", {}), "or a name with one number");
  EXPECT_INPUT_ERROR(ReadAll(), "body_0001.obj");
  WriteFrame(0, 0);
  EXPECT_INPUT_ERROR(ReadAll(.5), "0.5 frames per second");
}

TEST_F(BodySequenceTest, RefusesAnotherUnitOrAxisThanStated) {
  const std::vector<Vector3d> man = {{.3, .01, 0}, {0, .2, 0},  {-.3, 0, 0},
                                     {0, -.1, 0},  {0, 0, 1.7}, {0, 0, -.1}};
  auto other = man;
  for (Vector3d& v : other) v *= 100;
  WriteVertices(0, other);
  EXPECT_INPUT_ERROR(ReadAll(),
                     "body_0000.obj: extent, with --body_scale=1: found 180 m, expected about 0.4 "
                     "… 2.8 m; in cm it would be 1.8 m");
  for (std::size_t i = 0; i < man.size(); ++i) other[i] = {man[i].x(), man[i].z(), -man[i].y()};
  WriteVertices(0, other);
  EXPECT_INPUT_ERROR(ReadAll(),
                     "found a body of 0.6 m along x, 1.8 m along y and 0.3 m along z with "
                     "--body_up=z, expected one that is upright along z; try --body_up=y");
  BodyFiles crooked = kAsItIs;
  crooked.front = "z";
  EXPECT_INPUT_ERROR(ReadBodySequence(Path("body_0000.obj"), crooked), "expected a front across");
}

TEST_F(BodySequenceTest, RefusesAMissingNumber) {
  WriteFrame(0, 0);
  WriteFrame(1, .1);
  WriteFrame(4, .2);
  EXPECT_INPUT_ERROR(ReadAll(), "body_0002.obj: is missing, but ");
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
  EXPECT_EQ(ParseBody(Path("body_%04d.obj"), 0, kAsItIs)->num_vertices(), 6);
  EXPECT_GT(ParseBody("mannequin:turn", kRestArmAngle)->num_vertices(), 1000);
  EXPECT_INPUT_ERROR(ParseBody("mannequin:fly", kRestArmAngle),
                     "motion: found 'fly', expected one of stand, walk, turn, jump");
  EXPECT_INPUT_ERROR(ParseBody("mannequin", kRestArmAngle), "mannequin: ");
}

constexpr MotionKind kMotions[] = {MotionKind::kStand, MotionKind::kWalk, MotionKind::kTurn,
                                   MotionKind::kJump};

// Each is made once. Its arms are lifted to 80° at first.
const Mannequin& MakeMannequin(MotionKind kind) {
  static std::map<MotionKind, Mannequin> made;
  return made.try_emplace(kind, kind, std::numbers::pi / 2.25).first->second;
}

double Volume(const Body& body, const Eigen::VectorXd& x) {
  double volume = 0;
  for (const auto& t : body.triangles())
    volume += x.segment<3>(3 * t[0]).dot(x.segment<3>(3 * t[1]).cross(x.segment<3>(3 * t[2]))) / 6;
  return volume;
}

Vector3d Vertex(const Eigen::VectorXd& x, int i) { return x.segment<3>(3 * i); }

TEST(Mannequin, IsAClosedManifoldOfOnePiece) {
  const Mannequin& body = MakeMannequin(MotionKind::kStand);
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : body.triangles())
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
  }
  // Euler's formula for a sphere.
  EXPECT_EQ(body.num_vertices() - int(edges.size()) / 2 + int(body.triangles().size()), 2);
}

TEST(Mannequin, HasTrianglesOfEvenSize) {
  const Mannequin& body = MakeMannequin(MotionKind::kStand);
  const Eigen::VectorXd x = body.PositionsInPose({}, 1);
  double least_angle = 180, shortest = 1, longest = 0;
  for (const auto& t : body.triangles()) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d a = Vertex(x, t[k]), b = Vertex(x, t[(k + 1) % 3]),
                     c = Vertex(x, t[(k + 2) % 3]);
      const double cosine = (b - a).normalized().dot((c - a).normalized());
      least_angle = std::min(least_angle, std::acos(cosine) * 180 / std::numbers::pi);
      shortest = std::min(shortest, (b - a).norm());
      longest = std::max(longest, (b - a).norm());
    }
  }
  EXPECT_GT(least_angle, 25);
  EXPECT_GT(shortest, .010);
  EXPECT_LT(longest, .036);
}

TEST(Mannequin, IsSymmetric) {
  const Mannequin& body = MakeMannequin(MotionKind::kStand);
  const Eigen::VectorXd x = body.PositionsInPose({}, 1);
  double worst = 0;
  for (int i = 0; i < body.num_vertices(); ++i) {
    const Vector3d mirrored = Vertex(x, i).cwiseProduct(Vector3d(-1, 1, 1));
    double nearest = 1;
    for (int j = 0; j < body.num_vertices(); ++j)
      nearest = std::min(nearest, (Vertex(x, j) - mirrored).norm());
    worst = std::max(worst, nearest);
  }
  EXPECT_LT(worst, 1e-4);
}

TEST(Mannequin, DoesNotIntersectItselfInAnyMotion) {
  const Mannequin& still = MakeMannequin(MotionKind::kStand);
  EXPECT_THAT(FindSelfIntersections(still.triangles(), still.PositionsInPose({}, 1)), IsEmpty());
  for (const MotionKind kind : kMotions) {
    const Mannequin& body = MakeMannequin(kind);
    for (int k = 0; k < 20; ++k) {
      const double t = k < 5 ? .3 * k : 1.5 + .163 * (k - 5);
      EXPECT_THAT(FindSelfIntersections(body.triangles(), body.Positions(t)), IsEmpty())
          << ToString(kind) << " at " << t;
    }
  }
}

TEST(Mannequin, MovesContinuouslyAndKeepsItsVolume) {
  for (const MotionKind kind : kMotions) {
    const Mannequin& body = MakeMannequin(kind);
    double fastest = 0, least = 1, most = 0;
    for (double t = 0; t < 4; t += .0313) {
      const Eigen::VectorXd x = body.Positions(t), later = body.Positions(t + .001);
      for (int i = 0; i < body.num_vertices(); ++i)
        fastest = std::max(fastest, (Vertex(later, i) - Vertex(x, i)).norm());
      if (t < .5) continue;
      least = std::min(least, Volume(body, x));
      most = std::max(most, Volume(body, x));
    }
    EXPECT_LT(fastest, .005) << "m in a millisecond";
    EXPECT_LT(most / least, 1.05);
  }
}

TEST(Mannequin, BeginsAtHalfItsRadiiWithItsArmsLifted) {
  const Mannequin& body = MakeMannequin(MotionKind::kWalk);
  Pose lifted;
  lifted.arm_lift = {55 * std::numbers::pi / 180, 55 * std::numbers::pi / 180};
  EXPECT_LT((body.Positions(0) - body.PositionsInPose(lifted, .5)).cwiseAbs().maxCoeff(), 1e-9);
  // Full grown with the arms down, before the first stride.
  EXPECT_LT((body.Positions(1.25) - body.PositionsInPose({}, 1)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT((body.Positions(1.7) - body.PositionsInPose({}, 1)).cwiseAbs().maxCoeff(), .05);
  const Eigen::VectorXd half = body.PositionsInPose({}, .5);
  EXPECT_NEAR(Volume(body, half) / Volume(body, body.PositionsInPose({}, 1)), .25, .04);
}

TEST(Mannequin, ThePelvisCarriesWhatItHolds) {
  const Mannequin& body = MakeMannequin(MotionKind::kTurn);
  EXPECT_TRUE(body.PelvisMotion(0).isApprox(Eigen::Isometry3d::Identity()));
  // A vertex deep in the hips moves with it once the body is grown.
  const Eigen::VectorXd before = body.Positions(1.25), after = body.Positions(3);
  int hips = -1;
  for (int i = 0; i < body.num_vertices(); ++i)
    if (std::abs(Vertex(before, i).z() - .95) < .02 && std::abs(Vertex(before, i).x()) < .02)
      hips = i;
  ASSERT_GE(hips, 0);
  EXPECT_GT((Vertex(after, hips) - Vertex(before, hips)).norm(), .05);
  EXPECT_LT((body.PelvisMotion(3) * Vertex(before, hips) - Vertex(after, hips)).norm(), .01);
}

TEST(Mannequin, RefusesArmsNearTheBody) {
  EXPECT_THROW(Mannequin(MotionKind::kWalk, .1), InputError);
}

}  // namespace
}  // namespace drape
