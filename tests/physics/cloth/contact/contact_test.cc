// SPDX-License-Identifier: Apache-2.0
// The barrier, the distances from obstacles and their derivatives, and the moves that keep a cloth
// out of them.
#include "physics/cloth/contact/contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/math/random.h"
#include "tests/physics/cloth/contact/closed_mesh.h"

namespace drape {
namespace {

using Eigen::Vector3d;

Vector3d RandomVector(std::mt19937_64& random) {
  return {SampleNormal(random), SampleNormal(random), SampleNormal(random)};
}

// One of each kind, about 10 cm large, in no special position.
std::vector<Obstacle> EachObstacle() {
  return {PlaneObstacle{.normal = Eigen::Vector3d(1, 2, 3).normalized(), .offset = 0.01},
          SphereObstacle{.centre = {0.01, 0.02, -0.03}, .radius = 0.07},
          CapsuleObstacle{.from = {-0.05, 0.01, 0.0}, .to = {0.06, 0.03, 0.02}, .radius = 0.04},
          PlateObstacle{
              .top = {0.01, -0.02, 0.01}, .radius = 0.09, .thickness = 0.03, .rim_radius = 0.008}};
}

TEST(Barrier, HasThePressuresOfItsFormula) {
  constexpr double kRange = 5e-4;
  const double y[] = {0.9, 0.8, 0.7, 0.5, 0.3, 0.1};
  const double pressure[] = {0.03218, 0.13925, 0.34258, 1.19315, 3.31896, 12.2447};
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(-EvaluateBarrier(y[i] * kRange, kRange).slope, pressure[i], 2e-4 * pressure[i]);
}

TEST(Barrier, DerivativesAreDifferences) {
  constexpr double kRange = 5e-4, kStep = 1e-9;
  for (const double gap : {2e-5, 1e-4, 3e-4, 4.9e-4}) {
    const Barrier at = EvaluateBarrier(gap, kRange), before = EvaluateBarrier(gap - kStep, kRange),
                  after = EvaluateBarrier(gap + kStep, kRange);
    const auto close = [](double a, double b) { EXPECT_NEAR(a, b, 1e-6 * std::abs(b)); };
    close((after.value - before.value) / (2 * kStep), at.slope);
    close((after.slope - before.slope) / (2 * kStep), at.curvature);
    close((after.curvature - before.curvature) / (2 * kStep), at.third);
  }
}

TEST(Barrier, EndsWithTwoDerivatives) {
  constexpr double kRange = 5e-4;
  const Barrier inside = EvaluateBarrier(kRange * (1 - 1e-7), kRange);
  EXPECT_LT(inside.value, 1e-20);
  EXPECT_LT(std::abs(inside.slope), 1e-12);
  EXPECT_LT(inside.curvature * kRange, 1e-5);
  EXPECT_EQ(EvaluateBarrier(kRange, kRange).value, 0.0);
  EXPECT_TRUE(std::isinf(EvaluateBarrier(0.0, kRange).value));
}

TEST(Obstacle, DerivativesAreDifferences) {
  constexpr int kPoints = 300;
  constexpr double kStep = 1e-7;
  std::mt19937_64 random(1);
  for (const Obstacle& obstacle : EachObstacle()) {
    int tried = 0, smooth = 0;
    while (tried < kPoints) {
      const Eigen::Vector3d x = 0.08 * RandomVector(random);
      const ObstacleDistance at = DistanceTo(obstacle, x);
      if (at.value < 1e-3) continue;  // inside there are points with several nearest ones
      ++tried;
      EXPECT_NEAR(at.normal.norm(), 1.0, 1e-14);
      Eigen::Matrix3d curvature;
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(c);
        const ObstacleDistance after = DistanceTo(obstacle, x + step),
                               before = DistanceTo(obstacle, x - step);
        EXPECT_NEAR((after.value - before.value) / (2 * kStep), at.normal[c], 1e-6);
        curvature.col(c) = (after.normal - before.normal) / (2 * kStep);
      }
      smooth += (curvature - at.curvature).norm() < 1e-5 * (1.0 + at.curvature.norm());
    }
    EXPECT_GE(smooth, kPoints - 1) << obstacle.index();  // but for a difference across a jump
  }
}

// From the nearest of many points of the plate's surface.
TEST(Obstacle, PlateIsARectangleWithRoundCornersTurnedAboutItsAxis) {
  const PlateObstacle plate{
      .top = {0, 0, 0}, .radius = 0.09, .thickness = 0.03, .rim_radius = 0.008};
  std::vector<Eigen::Vector2d> surface;  // of the half-plane x ≥ 0
  constexpr int kPoints = 2000;
  for (int k = 0; k <= kPoints; ++k) {
    const double share = static_cast<double>(k) / kPoints, angle = 0.5 * M_PI * share;
    for (const double side : {0.0, -1.0}) {
      surface.emplace_back(0.082 * share, 0.03 * side);
      const double up = side == 0.0 ? 1.0 : -1.0;
      surface.emplace_back(0.082 + 0.008 * std::sin(angle),
                           -0.015 + up * (0.007 + 0.008 * std::cos(angle)));
    }
    surface.emplace_back(0.09, -0.008 - 0.014 * share);
  }
  std::mt19937_64 random(2);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x = 0.08 * RandomVector(random);
    const double value = DistanceTo(plate, x).value;
    if (value < 0.0) continue;
    double nearest = 1.0;
    for (const Eigen::Vector2d& point : surface)
      nearest = std::min(nearest, (point - Eigen::Vector2d(x.head<2>().norm(), x.z())).norm());
    EXPECT_NEAR(value, nearest, 1e-6);
  }
}

class ContactTest : public testing::Test {
 protected:
  // Points with a gap that pushes, some of two obstacles at once.
  std::vector<Eigen::Vector3d> NearPoints() {
    std::vector<Eigen::Vector3d> points;
    std::mt19937_64 random(3);
    while (points.size() < 200) {
      const Eigen::Vector3d x = 0.08 * RandomVector(random);
      const double gap = SmallestGap(contact_, x);
      if (gap > 0.05 * contact_.range && gap < 0.9 * contact_.range) points.push_back(x);
    }
    return points;
  }

  static constexpr double kArea = 3e-5;
  // Wide, so that points are found.
  Contact contact_{.thickness = 2e-3, .range = 0.02, .obstacles = EachObstacle()};
};

TEST_F(ContactTest, ForceIsTheSlopeOfTheEnergy) {
  constexpr double kStep = 1e-7;
  for (const Eigen::Vector3d& x : NearPoints()) {
    const Eigen::Vector3d force = ContactForce(contact_, kArea, x);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(c);
      const double slope =
          (ContactEnergy(contact_, kArea, x + step) - ContactEnergy(contact_, kArea, x - step)) /
          (2 * kStep);
      EXPECT_NEAR(-slope, force[c], 1e-5 * force.norm());
    }
  }
}

// What kernels compute; compilers may fuse operations in one place and not in another.
TEST_F(ContactTest, PlainDataGiveTheSame) {
  constexpr double kRounding = 1e-12;
  std::vector<Solid> solids;
  for (const Obstacle& obstacle : contact_.obstacles) solids.push_back(MakeSolid(obstacle));
  const SolidContact plain{contact_.thickness, contact_.range, contact_.stiffness,
                           static_cast<int>(solids.size()), solids.data()};
  const auto expect_near = [&](const Vec3<double>& a, const Eigen::Vector3d& b) {
    EXPECT_LE((Eigen::Vector3d(a.x, a.y, a.z) - b).norm(), kRounding * b.norm());
  };
  std::mt19937_64 random(6);
  for (const Eigen::Vector3d& x : NearPoints()) {
    const Vec3<double> at{x.x(), x.y(), x.z()};
    const double energy = ContactEnergy(contact_, kArea, x);
    EXPECT_NEAR(VertexEnergy(plain, kArea, at), energy, kRounding * energy);
    expect_near(VertexForce(plain, kArea, at), ContactForce(contact_, kArea, x));
    const Eigen::Vector3d w = RandomVector(random);
    double block[9] = {};
    AddVertexStepDerivative(plain, kArea, at, {w.x(), w.y(), w.z()}, 0.1, block);
    const Eigen::Matrix3d derivative = ContactStepDerivative(contact_, kArea, x, w, 0.1);
    for (int n = 0; n < 9; ++n)
      EXPECT_NEAR(block[n], derivative(n / 3, n % 3), kRounding * derivative.norm());
    Eigen::VectorXd move = 0.05 * w;
    const Vec3<double> wanted{move[0], move[1], move[2]};
    ShortenMoves(contact_, x, move);
    expect_near(SafeShare(plain, at, wanted) * wanted, move);
    Vec3<double> pushed{0.9 * x.x(), 0.9 * x.y(), 0.9 * x.z()};
    Eigen::VectorXd out = 0.9 * x;
    EXPECT_EQ(PushVertexOut(plain, pushed), PushOut(contact_, out));
    expect_near(pushed, out);
  }
}

TEST_F(ContactTest, StepDerivativeIsADifference) {
  constexpr double kStep = 1e-8, kTime = 0.05;
  std::mt19937_64 random(4);
  const auto step_force = [&](const Eigen::Vector3d& x,
                              const Eigen::Vector3d& w) -> Eigen::Vector3d {
    return kTime * ContactForce(contact_, kArea, x) -
           kTime * kTime * ContactStepStiffness(contact_, kArea, x) * w;
  };
  int smooth = 0;
  for (const Eigen::Vector3d& x : NearPoints()) {
    const Eigen::Vector3d w = RandomVector(random);
    const Eigen::Matrix3d exact = ContactStepDerivative(contact_, kArea, x, w, kTime);
    Eigen::Matrix3d difference;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(c);
      difference.col(c) = (step_force(x + step, w) - step_force(x - step, w)) / (2 * kStep);
    }
    smooth += (difference - exact).norm() < 1e-5 * exact.norm();
  }
  EXPECT_GE(smooth, 198);  // the others have a jump of the curvature within the difference
}

TEST_F(ContactTest, ShortenedMovesKeepATenthOfTheGap) {
  std::mt19937_64 random(5);
  int shortened = 0;
  for (const Eigen::Vector3d& x : NearPoints()) {
    Eigen::VectorXd dx = 0.05 * RandomVector(random);
    const Eigen::VectorXd wanted = dx;
    const bool is_shortened = ShortenMoves(contact_, x, dx);
    EXPECT_EQ(is_shortened, dx != wanted);
    shortened += is_shortened;
    const double first = SmallestGap(contact_, x);
    double least = first, least_wanted = first;
    for (int k = 0; k <= 500; ++k) {
      least = std::min(least, SmallestGap(contact_, x + k / 500.0 * dx));
      least_wanted = std::min(least_wanted, SmallestGap(contact_, x + k / 500.0 * wanted));
    }
    EXPECT_GT(least, 0.099 * first);
    if (is_shortened) {
      EXPECT_LT(least_wanted, 0.13 * first);
    } else {
      EXPECT_GT(least_wanted, 0.0);
    }
  }
  EXPECT_GT(shortened, 40);
}

TEST_F(ContactTest, MovesAlongASurfaceAreNotShortened) {
  contact_.obstacles = {PlaneObstacle{}};
  const Eigen::VectorXd x = Eigen::Vector3d(0.0, 0.0, 0.5 * contact_.thickness + 1e-7);
  Eigen::VectorXd dx = Eigen::Vector3d(0.3, 0.0, 0.0);
  EXPECT_FALSE(ShortenMoves(contact_, x, dx));
}

// Shortened moves against the least distance on the whole straight way, in closed form or by exact
// predicates.

// The least distance of two segments, by the ends and the inner points of both [Ericson 2005].
double SegmentDistance(const Vector3d& p, const Vector3d& dp, const Vector3d& q,
                       const Vector3d& dq) {
  const auto to_point = [](const Vector3d& point, const Vector3d& from, const Vector3d& along) {
    const double square = along.squaredNorm();
    const double share =
        square > 0.0 ? std::clamp((point - from).dot(along) / square, 0.0, 1.0) : 0.0;
    return (from + share * along - point).norm();
  };
  double least = std::min(
      {to_point(p, q, dq), to_point(p + dp, q, dq), to_point(q, p, dp), to_point(q + dq, p, dp)});
  Eigen::Matrix2d system;
  system << dp.dot(dp), -dp.dot(dq), -dp.dot(dq), dq.dot(dq);
  if (!(system.determinant() > 0.0)) return least;
  const Eigen::Vector2d shares = system.inverse() * Eigen::Vector2d(dp.dot(q - p), -dq.dot(q - p));
  if (shares.minCoeff() >= 0.0 && shares.maxCoeff() <= 1.0)
    least = std::min(least, (p + shares[0] * dp - q - shares[1] * dq).norm());
  return least;
}

// A move from a point: of any length and direction, towards the obstacle, along it, or none.
Vector3d RandomMove(const ObstacleDistance& at, std::mt19937_64& random) {
  const double length = std::pow(10.0, std::uniform_real_distribution(-9.0, 0.5)(random));
  const Vector3d any = length * RandomVector(random);
  switch (std::uniform_int_distribution(0, 4)(random)) {
    case 0:
      return -length * at.normal;
    case 1:
      return any - any.dot(at.normal) * at.normal;
    case 2:
      return Vector3d::Zero();
    default:
      return any;
  }
}

// Moves from gaps of 1e-12 m to 1 m from one obstacle. gap(x, dx): the least on the way.
void ExpectNoMissedContact(const Obstacle& obstacle, double size, int queries,
                           const std::function<double(const Vector3d&, const Vector3d&)>& gap) {
  const Contact contact{.thickness = 1e-3, .obstacles = {obstacle}};
  std::mt19937_64 random(11);
  int hits = 0, shortened = 0, missed = 0, wrong = 0;
  for (int i = 0; i < queries; ++i) {
    Eigen::VectorXd x = size * RandomVector(random);
    // To the gap that is asked for, along the normal; where that leads out of the same face, near.
    const ObstacleDistance at = DistanceTo(obstacle, x);
    const double asked = std::pow(10.0, std::uniform_real_distribution(-12.0, 0.0)(random));
    x += (asked + 0.5 * contact.thickness - at.value) * at.normal;
    const double first = SmallestGap(contact, x);
    if (!(first > 1e-15)) continue;
    const Eigen::VectorXd wanted = RandomMove(DistanceTo(obstacle, x), random);
    Eigen::VectorXd move = wanted;
    const bool is_shortened = Clearance(contact, x).ShortenMoves(x, move);
    const double least = gap(x, wanted) - 0.5 * contact.thickness;
    // Rounding of places of about a metre.
    constexpr double kRounding = 1e-15;
    missed += gap(x, move) - 0.5 * contact.thickness < 0.0999 * first - kRounding;
    wrong += is_shortened && least > 0.13 * first + kRounding;
    hits += least < 0.0;
    shortened += is_shortened;
  }
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(hits, queries / 20);
  EXPECT_GE(shortened, hits);
}

TEST(Filter, MissesNoPlane) {
  const PlaneObstacle plane{.normal = Vector3d(1, 2, 3).normalized(), .offset = 0.01};
  ExpectNoMissedContact(plane, 0.1, 250000, [&](const Vector3d& x, const Vector3d& dx) {
    return std::min(plane.normal.dot(x), plane.normal.dot(x + dx)) - plane.offset;
  });
}

TEST(Filter, MissesNoSphere) {
  const SphereObstacle sphere{.centre = {0.01, 0.02, -0.03}, .radius = 0.07};
  ExpectNoMissedContact(sphere, 0.1, 250000, [&](const Vector3d& x, const Vector3d& dx) {
    return SegmentDistance(x, dx, sphere.centre, Vector3d::Zero()) - sphere.radius;
  });
}

TEST(Filter, MissesNoCapsule) {
  const CapsuleObstacle capsule{
      .from = {-0.05, 0.01, 0.0}, .to = {0.06, 0.03, 0.02}, .radius = 0.04};
  ExpectNoMissedContact(capsule, 0.1, 250000, [&](const Vector3d& x, const Vector3d& dx) {
    return SegmentDistance(x, dx, capsule.from, capsule.to - capsule.from) - capsule.radius;
  });
}

// The distance from a convex solid is convex along a line: its least value by thirds.
TEST(Filter, MissesNoPlate) {
  const PlateObstacle plate{
      .top = {0.01, -0.02, 0.01}, .radius = 0.09, .thickness = 0.03, .rim_radius = 0.008};
  ExpectNoMissedContact(plate, 0.1, 50000, [&](const Vector3d& x, const Vector3d& dx) {
    double low = 0.0, high = 1.0, least = DistanceTo(plate, x).value;
    for (int i = 0; i < 80; ++i) {
      const double one = low + (high - low) / 3.0, other = high - (high - low) / 3.0;
      const double at_one = DistanceTo(plate, x + one * dx).value,
                   at_other = DistanceTo(plate, x + other * dx).value;
      least = std::min({least, at_one, at_other});
      (at_one < at_other ? high : low) = at_one < at_other ? other : one;
    }
    return std::min(least, DistanceTo(plate, x + dx).value);
  });
}

// Coarse, with sharp edges. A way is the thinnest triangle around it.
void ExpectNoMissedTriangle(const test::ClosedMesh& mesh, double size) {
  const Contact contact{
      .thickness = 0.0,
      .obstacles = {std::make_shared<const SurfaceObstacle>(mesh.x, mesh.triangles)}};
  const int corners = static_cast<int>(mesh.x.cols());
  std::vector<std::array<int, 3>> triangles = mesh.triangles;
  triangles.push_back({corners, corners + 1, corners + 2});
  const auto meets = [&](const Vector3d& x, const Vector3d& dx) {
    Eigen::VectorXd all(3 * corners + 9);
    all << mesh.x.reshaped(), x, x + dx, x + 0.5 * dx + 1e-13 * dx.unitOrthogonal();
    return !FindSelfIntersections(triangles, all).empty();
  };
  std::mt19937_64 random(12);
  int hits = 0, missed = 0, queries = 0;
  while (queries < 4000) {
    Eigen::VectorXd x = size * RandomVector(random);
    // Most of them close, where a move may go far along the surface.
    const ObstacleDistance at = DistanceTo(contact.obstacles[0], x);
    const double away = std::pow(10.0, std::uniform_real_distribution(-6.0, -1.5)(random));
    x += std::min(0.0, away - at.value) * at.normal;
    // Out of reach nothing tells the inside of a solid.
    if (at.value > 0.029 || !(SmallestGap(contact, x) > 1e-9)) continue;
    ++queries;
    const Eigen::VectorXd wanted = 2.0 * size * RandomVector(random);
    Eigen::VectorXd move = wanted;
    Clearance(contact, x).ShortenMoves(x, move);
    hits += meets(x, wanted);
    missed += (move.norm() > 1e-9 && meets(x, move)) || !(SmallestGap(contact, x + move) > 0.0);
  }
  EXPECT_EQ(missed, 0);
  EXPECT_GT(hits, queries / 5);
}

TEST(Filter, MissesNoTriangleOfAMesh) {
  ExpectNoMissedTriangle(test::MakeBall(0.1, 1), 0.1);
  ExpectNoMissedTriangle(test::MakeRing(0.08, 0.03, 8, 6), 0.08);
}

}  // namespace
}  // namespace drape
