// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/obstacles/surface_obstacle.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/pairs/contact_pair.h"
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

std::shared_ptr<const SurfaceObstacle> Places(const test::ClosedMesh& mesh) {
  return std::make_shared<const SurfaceObstacle>(mesh.x, mesh.triangles, Eigen::Matrix3Xd(), 0.03,
                                                 SurfaceBlend::kPlaces);
}

double NearestOfAll(const test::ClosedMesh& mesh, const Eigen::Vector3d& x) {
  double nearest = 1.0;
  for (const auto& [p, q, r] : mesh.triangles) {
    const Eigen::Vector3d a = mesh.x.col(p), b = mesh.x.col(q), c = mesh.x.col(r);
    const Eigen::Vector3d weights = NearestWeights(x, a, b, c);
    nearest = std::min(nearest, (x - weights[0] * a - weights[1] * b - weights[2] * c).norm());
  }
  return nearest;
}

class SurfacePlacesTest : public testing::Test {
 protected:
  Eigen::Vector3d Normal() {
    return {SampleNormal(random_), SampleNormal(random_), SampleNormal(random_)};
  }
  // Points outside at distances from .1 mm to 8 mm, half of them near the concave edge.
  std::vector<Eigen::Vector3d> PointsAtStair(int count) {
    std::vector<Eigen::Vector3d> points;
    while (static_cast<int>(points.size()) < count) {
      Eigen::Vector3d x = Eigen::Vector3d(0.05, 0.05, 0.05) + 0.03 * Normal();
      if (points.size() % 2 == 0)
        x = {0.05 + 0.001 * Normal()[0], 0.03, 0.05 + 0.001 * Normal()[1]};
      const double value = stair_->DistanceTo(x).value;
      if (value > 1e-4 && value < 8e-3) points.push_back(x);
    }
    return points;
  }

  std::mt19937_64 random_{2};
  test::ClosedMesh stair_mesh_ = test::MakeStair(0.05, 0.1);
  std::shared_ptr<const SurfaceObstacle> stair_ = Places(stair_mesh_);
};

// Facets, edges and corners, flat and convex: nothing is blended.
TEST_F(SurfacePlacesTest, WhatIsConvexHasItsDistance) {
  for (const test::ClosedMesh& mesh : {test::MakeBall(0.05, 3), test::MakeCube(0.05)}) {
    const auto surface = Places(mesh);
    EXPECT_TRUE(surface->view().is_convex);
    int outside = 0;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d x = 0.04 * Normal();
      const ObstacleDistance distance = surface->DistanceTo(x);
      if (!(distance.value > 0.0) || distance.value > 0.02) continue;
      ++outside;
      EXPECT_NEAR(distance.value, NearestOfAll(mesh, x), 1e-14);
      EXPECT_NEAR(distance.normal.norm(), 1.0, 1e-10);
    }
    EXPECT_GT(outside, 300);
  }
  EXPECT_FALSE(stair_->view().is_convex);
}

// With the square of the edges, as the facets approach the ball.
TEST_F(SurfacePlacesTest, FinerBallsConvergeToTheBall) {
  constexpr double kBall = 0.05, kAway = 6e-4;
  double before = 0.0;
  for (int divisions = 2; divisions <= 5; ++divisions) {
    const auto surface = Places(test::MakeBall(kBall, divisions));
    double most = 0.0;
    for (int i = 0; i < 500; ++i) {
      const double value = surface->DistanceTo((kBall + kAway) * Normal().normalized()).value;
      EXPECT_GT(value, kAway - 1e-12);  // the facets are inside of the ball
      most = std::max(most, value - kAway);
    }
    if (before > 0.0) {
      EXPECT_LT(most, before / 3.3) << divisions;
      EXPECT_GT(most, before / 4.7) << divisions;
    }
    before = most;
  }
  EXPECT_LT(before, 5e-5);
}

TEST_F(SurfacePlacesTest, AConcaveEdgeIsBlended) {
  // In the middle of the two treads both are as near.
  const double away = 0.004;
  const ObstacleDistance at = stair_->DistanceTo({0.05 + away, 0.03, 0.05 + away});
  EXPECT_NEAR(at.value, away - kSurfaceBlend * M_LN2, 1e-9);
  EXPECT_NEAR(at.normal.norm(), M_SQRT1_2, 5e-3);
  EXPECT_LT(at.curvature.trace(), -0.5 / kSurfaceBlend);
  // A tread alone, over the edge between its facets too.
  for (const double y : {0.01, 0.05, 0.09})
    EXPECT_NEAR(stair_->DistanceTo({0.08, y, 0.05 + 7e-4}).value, 7e-4, 1e-14);
}

// In the middle of a ring the sum over its facets and edges is less than the nearest facet alone.
TEST_F(SurfacePlacesTest, NoDistanceIsLongerThanThatOfTheNearestPoint) {
  const test::ClosedMesh ring = test::MakeRing(0.012, 0.01, 300, 12);
  const auto surface = Places(ring);
  for (int i = 0; i < 300; ++i) {
    const double off = i < 100 ? 1e-6 : 5e-4;
    const Eigen::Vector3d x = off * Normal();
    EXPECT_LT(surface->DistanceTo(x).value, NearestOfAll(ring, x) + 1e-14);
  }
}

TEST_F(SurfacePlacesTest, DerivativesAreDifferences) {
  constexpr double kStep = 1e-7;
  const std::vector<Eigen::Vector3d> points = PointsAtStair(400);
  int smooth = 0, blended = 0;
  for (const Eigen::Vector3d& x : points) {
    const ObstacleDistance at = stair_->DistanceTo(x);
    Eigen::Vector3d slope;
    Eigen::Matrix3d curvature;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(c);
      const ObstacleDistance after = stair_->DistanceTo(x + step),
                             before = stair_->DistanceTo(x - step);
      slope[c] = (after.value - before.value) / (2 * kStep);
      curvature.col(c) = (after.normal - before.normal) / (2 * kStep);
    }
    EXPECT_LT((slope - at.normal).norm(), 1e-6);
    smooth += (curvature - at.curvature).norm() < 1e-5 * (1.0 + at.curvature.norm());
    blended += at.curvature.trace() < -1.0;
  }
  EXPECT_GE(smooth, 396);  // the others have a jump of the curvature within the difference
  EXPECT_GT(blended, 100);
}

TEST_F(SurfacePlacesTest, StepDerivativeIsADifference) {
  constexpr double kStep = 1e-9, kTime = 0.05, kArea = 3e-5;
  const Contact contact{.thickness = 0.0, .range = 8e-3, .obstacles = {stair_}};
  const auto step_force = [&](const Eigen::Vector3d& x,
                              const Eigen::Vector3d& w) -> Eigen::Vector3d {
    return kTime * ContactForce(contact, kArea, x) -
           kTime * kTime * ContactStepStiffness(contact, kArea, x) * w;
  };
  int smooth = 0;
  for (const Eigen::Vector3d& x : PointsAtStair(300)) {
    const Eigen::Vector3d w = Normal();
    const Eigen::Matrix3d exact = ContactStepDerivative(contact, kArea, x, w, kTime);
    Eigen::Matrix3d difference;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(c);
      difference.col(c) = (step_force(x + step, w) - step_force(x - step, w)) / (2 * kStep);
    }
    smooth += (difference - exact).norm() < 1e-5 * exact.norm();
    const Eigen::Matrix3d stiffness = ContactStepStiffness(contact, kArea, x);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(stiffness).eigenvalues()[0],
              -1e-9 * stiffness.norm());
  }
  EXPECT_GE(smooth, 294);
}

TEST_F(SurfacePlacesTest, NoMoveEntersIt) {
  const Contact contact{.obstacles = {stair_, Places(test::MakeBall(0.03, 3))}};
  int shortened = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::VectorXd x = Eigen::Vector3d(0.04 * Normal());
    const double first = SmallestGap(contact, x);
    if (!(first > 0.0) || stair_->Encloses(x)) continue;
    Eigen::VectorXd dx = 0.1 * Normal();
    shortened += ShortenMoves(contact, x, dx);
    for (int k = 0; k <= 200; ++k)
      ASSERT_GT(SmallestGap(contact, x + k / 200.0 * dx), 0.09 * first) << i;
  }
  EXPECT_GT(shortened, 50);
}

TEST_F(SurfacePlacesTest, KnowsItsInsideHoweverDeep) {
  const auto cube = Places(test::MakeCube(0.4));
  EXPECT_TRUE(cube->Encloses({0.2, 0.2, 0.2}));
  EXPECT_TRUE(cube->Encloses({0.01, 0.39, 0.2}));
  EXPECT_FALSE(cube->Encloses({0.2, 0.2, 0.41}));
  EXPECT_FALSE(cube->Encloses({-1.0, 0.2, 0.2}));
  EXPECT_TRUE(stair_->Encloses({0.02, 0.05, 0.09}));
  EXPECT_FALSE(stair_->Encloses({0.08, 0.05, 0.09}));
}

// Cells of a grid over a large mesh are larger, and triangles are only in those near them.
TEST_F(SurfacePlacesTest, SizeDoesNotChangeDistances) {
  const auto large = Places(test::MakeStair(5.0, 10.0));
  for (const double away : {1e-4, 7e-4, 0.02}) {
    EXPECT_NEAR(large->DistanceTo({7.3, 2.1, 5.0 + away}).value, away, 1e-13);
    EXPECT_NEAR(large->DistanceTo({1.0, 9.9, 10.0 + away}).value, away, 1e-13);
    EXPECT_NEAR(large->DistanceTo({1.0, 10.0 + away, 0.1}).value, away, 1e-13);
  }
  EXPECT_LT(large->lists().cell_triangle.size(), 400000u);
}

}  // namespace
}  // namespace drape
