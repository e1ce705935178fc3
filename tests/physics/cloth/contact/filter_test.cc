// SPDX-License-Identifier: Apache-2.0
// Shortened moves against the least distance on the whole straight way, in closed form or by exact
// predicates.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/mesh/self_intersection.h"
#include "physics/util/math/random.h"
#include "tests/physics/cloth/contact/closed_mesh.h"

namespace drape {
namespace {

using Eigen::Vector3d;

Vector3d RandomVector(std::mt19937_64& random) {
  return {SampleNormal(random), SampleNormal(random), SampleNormal(random)};
}

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
