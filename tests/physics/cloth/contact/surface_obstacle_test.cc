// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/surface_obstacle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "physics/cloth/contact/contact.h"
#include "physics/util/math/random.h"
#include "tests/physics/cloth/contact/closed_mesh.h"

namespace drape {
namespace {

constexpr double kRadius = 0.1;

class SurfaceObstacleTest : public testing::Test {
 protected:
  // A point `away` from the surface of the ball in a random direction.
  Eigen::Vector3d Point(double away) {
    const Eigen::Vector3d direction(SampleNormal(random_), SampleNormal(random_),
                                    SampleNormal(random_));
    return (kRadius + away) * direction.normalized();
  }

  std::mt19937_64 random_{1};
  test::ClosedMesh ball_ = test::MakeBall(kRadius, 4);
  SurfaceObstacle surface_{ball_.x, ball_.triangles};
  // The middle of a facet lies up to ℓ²/6R = .3 mm inside of the ball, for which distances are
  // longer; over a corner the blend makes them shorter by .3 mm·ln 6.
  double sagitta_ = 1e-3;
};

TEST_F(SurfaceObstacleTest, IsTheBallToItsFacets) {
  for (int i = 0; i < 500; ++i)
    for (const double away : {-0.02, -0.002, 0.0005, 0.005, 0.025}) {
      const Eigen::Vector3d x = Point(away);
      const ObstacleDistance distance = surface_.DistanceTo(x);
      EXPECT_NEAR(distance.value, away, sagitta_);
      EXPECT_GT(distance.normal.dot(x.normalized()), std::abs(away) < 0.001 ? 0.5 : 0.9);
    }
}

TEST_F(SurfaceObstacleTest, NormalIsTheSlope) {
  constexpr double kStep = 1e-7;
  int smooth = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d x = Point(0.004);
    const ObstacleDistance at = surface_.DistanceTo(x);
    Eigen::Vector3d slope;
    for (int c = 0; c < 3; ++c)
      slope[c] = (surface_.DistanceTo(x + kStep * Eigen::Vector3d::Unit(c)).value -
                  surface_.DistanceTo(x - kStep * Eigen::Vector3d::Unit(c)).value) /
                 (2 * kStep);
    smooth += (slope - at.normal).norm() < 1e-6;
  }
  EXPECT_GE(smooth, 498);
}

TEST_F(SurfaceObstacleTest, OutOfReachNothingIsKnownButThat) {
  const ObstacleDistance far = surface_.DistanceTo({0.2, 0.0, 0.0});
  EXPECT_EQ(far.value, 0.03);
  EXPECT_TRUE(far.normal.isZero());
  EXPECT_EQ(surface_.DistanceTo({5.0, 0.0, 0.0}).value, 0.03);
}

TEST_F(SurfaceObstacleTest, MovesAsItsPointsDo) {
  const Eigen::Vector3d shift(0.001, -0.002, 0.003);
  const SurfaceObstacle moved(ball_.x, ball_.triangles, ball_.x.colwise() - shift);
  EXPECT_LT((moved.Move(Point(0.003)) - shift).norm(), 1e-15);
  EXPECT_TRUE(surface_.Move(Point(0.003)).isZero());
}

TEST_F(SurfaceObstacleTest, NoMoveEntersIt) {
  const Contact contact{.obstacles = {std::make_shared<const SurfaceObstacle>(surface_)}};
  for (int i = 0; i < 300; ++i) {
    const Eigen::VectorXd x = Point(0.005);
    Eigen::VectorXd dx = Point(0.0) - x;  // often through the ball
    const double first = SmallestGap(contact, x);
    ShortenMoves(contact, x, dx);
    for (int k = 0; k <= 200; ++k)
      ASSERT_GT(SmallestGap(contact, x + k / 200.0 * dx), 0.09 * first);
  }
}

TEST_F(SurfaceObstacleTest, PushesOutWhatItHasSwallowed) {
  const Contact contact{.obstacles = {std::make_shared<const SurfaceObstacle>(surface_)}};
  for (int i = 0; i < 200; ++i) {
    Eigen::VectorXd x = Point(-0.01);
    EXPECT_TRUE(PushOut(contact, x));
    EXPECT_GT(SmallestGap(contact, x), 0.0);
    EXPECT_NEAR(x.norm(), kRadius, 2 * sagitta_);
  }
}

}  // namespace
}  // namespace drape
