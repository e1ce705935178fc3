// SPDX-License-Identifier: Apache-2.0
// The barrier, the distances from obstacles and their derivatives, and the moves that keep a cloth
// out of them.
#include "physics/cloth/contact/contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "physics/cloth/contact/vertex_contact.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

Eigen::Vector3d RandomVector(std::mt19937_64& random) {
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

}  // namespace
}  // namespace drape
