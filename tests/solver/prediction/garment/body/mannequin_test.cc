// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <map>
#include <memory>
#include <numbers>

#include "physics/mesh/self_intersection.h"
#include "physics/util/errors.h"
#include "solver/prediction/garment/body/body.h"

namespace drape {
namespace {

using Eigen::Vector3d;
using ::testing::IsEmpty;

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
