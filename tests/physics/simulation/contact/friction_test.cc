// SPDX-License-Identifier: Apache-2.0
// Implicit Euler with contact and friction: a sheet on a slope, and on a turning ball.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/mesh/disc.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth/contact/sheets.h"

namespace drape {
namespace {

using test::kGravity;

constexpr double kCreep = 1e-3;

// Gravity on a slope of tan = .5 along x, in the frame of the slope.
std::shared_ptr<const ClothModel> SheetOnSlope() {
  Scene scene;
  const double angle = std::atan(0.5);
  scene.gravity = kGravity * Eigen::Vector3d(std::sin(angle), 0.0, -std::cos(angle));
  scene.contact = Contact{.obstacles = {PlaneObstacle{}}};
  return std::make_shared<ClothModel>(MakeDisc({.target_vertices = 100}), scene, MakeLaw("smooth"));
}

// The mean speed along the slope after so many steps of .01 s from rest.
double SlidingSpeed(double friction, int steps) {
  const auto model = SheetOnSlope();
  ImplicitEuler euler(model, LinearMaterial(100.0, 1e-5, 0.2), 0.01,
                      {.tolerance = 1e-10, .friction = friction, .creep_speed = kCreep});
  State state = model->RestState();
  for (Eigen::Index i = 2; i < state.x.size(); i += 3) state.x[i] = 0.66e-3;
  for (int step = 0; step < steps; ++step)
    EXPECT_EQ(euler.Advance(state), IntegratorStatus::kOk) << step;
  return Eigen::Map<const Eigen::Matrix3Xd>(state.v.data(), 3, state.v.size() / 3).row(0).mean();
}

struct SlidingPoint {
  Rub rub{.limit = 0.3, .normal = Eigen::Vector3d(1.0, 2.0, 2.0) / 3.0};
  Eigen::Vector3d along = Eigen::Vector3d(2.0, 1.0, -2.0) / 3.0,
                  across = Eigen::Vector3d(2.0, -2.0, 1.0) / 3.0;
  Eigen::Vector3d At(double slip) const { return slip * along + 0.1 * rub.normal; }
};

// With the share that the force has, below the speed of creep and above it.
TEST(Friction, TheStiffnessIsTheDerivativeOfTheForce) {
  constexpr double kH = 0.01, kStep = 1e-9;
  SlidingPoint point;
  for (const double slip : {2e-6, 7e-6, 3e-5, 1e-3}) {
    const Eigen::Vector3d x = point.At(slip) + 0.5 * slip * point.across;
    point.rub.share = -EvaluateRub(point.rub, x, kCreep, kH).force / point.rub.limit;
    const Eigen::Matrix3d stiffness = EvaluateRub(point.rub, x, kCreep, kH).stiffness;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d difference = (EvaluateRub(point.rub, x - step, kCreep, kH).force -
                                          EvaluateRub(point.rub, x + step, kCreep, kH).force) /
                                         (2.0 * kStep);
      EXPECT_LT((stiffness.col(k) - difference).norm(), 1e-5 * stiffness.norm()) << slip;
    }
  }
}

// A contact that slid the other way before resists at once, whatever the share.
TEST(Friction, TheStiffnessIsPositiveAndStopsAReversal) {
  constexpr double kH = 0.01, kSlip = 1e-3;
  SlidingPoint point;
  for (int k = 0; k < 12; ++k) {
    const double angle = M_PI * k / 6.0;
    point.rub.share = std::cos(angle) * point.along + std::sin(angle) * point.across;
    const Eigen::Matrix3d stiffness = EvaluateRub(point.rub, point.At(kSlip), kCreep, kH).stiffness;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(stiffness);
    EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-9 * stiffness.norm()) << k;
    const double secant = point.rub.limit / kSlip;
    EXPECT_NEAR(point.along.dot(stiffness * point.along), (1.0 - std::cos(angle)) * secant,
                1e-9 * secant)
        << k;
  }
}

// It follows the force as far as that is linear, and is never more than the limit.
TEST(Friction, TheShareFollowsTheForceToFirstOrder) {
  constexpr double kH = 0.01;
  SlidingPoint point;
  const auto share = [&](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return -EvaluateRub(point.rub, x, kCreep, kH).force / point.rub.limit;
  };
  for (const double slip : {3e-6, 1e-3}) {
    const Eigen::Vector3d from = point.At(slip), by = 1e-4 * slip * point.across,
                          to = from + by + 1e-4 * slip * point.along;
    point.rub.share = share(from);
    EXPECT_LT((ShareAfter(point.rub, from, to, kCreep, kH) - share(to)).norm(), 1e-7) << slip;
    EXPECT_LE(ShareAfter(point.rub, from, from - 9.0 * slip * point.along, kCreep, kH).norm(),
              1.0 + 1e-12);
  }
}

TEST(Friction, ASheetSlidesWithTheAccelerationOfCoulomb) {
  const double angle = std::atan(0.5);
  for (const double friction : {0.0, 0.3}) {
    const double gained = SlidingSpeed(friction, 60) - SlidingSpeed(friction, 30);
    const double expected = 0.3 * kGravity * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(gained, expected, 0.01 * expected) << friction;
  }
}

// Below the threshold the smoothed law creeps: v = ε(1 − √(1 − tan/μ)).
TEST(Friction, BelowTheThresholdASheetCreepsAtTheSpeedOfTheLaw) {
  for (const double friction : {0.51, 0.6}) {
    const double expected = kCreep * (1.0 - std::sqrt(1.0 - 0.5 / friction));
    EXPECT_NEAR(SlidingSpeed(friction, 80), expected, 0.01 * expected) << friction;
  }
  EXPECT_GT(SlidingSpeed(0.49, 80), 10 * kCreep);
}

// A cloth on a ball that turns about the vertical axis at 1 revolution a second.
TEST(Friction, ATurningBallCarriesTheCloth) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -kGravity);
  const auto model =
      std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), scene, MakeLaw("smooth"));
  const test::ClosedMesh ball = test::MakeBall(0.12, 4);
  const Eigen::Matrix3Xd below = ball.x.colwise() - Eigen::Vector3d(0.0, 0.0, 0.124);
  constexpr double kStep = 0.01, kTurn = 2 * M_PI * kStep;
  const auto turned = [&](int step) -> Eigen::Matrix3Xd {
    const double turn = kTurn * std::max(0, step - 20);
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    rotation.topLeftCorner<2, 2>() << std::cos(turn), -std::sin(turn), std::sin(turn),
        std::cos(turn);
    return rotation * below;
  };
  const auto angular_speed = [&](double friction) {
    ImplicitEuler euler(model, LinearMaterial(200.0, 5e-6, 0.2), kStep, {.friction = friction});
    State state = model->RestState();
    for (int step = 0; step < 40; ++step) {
      const auto surface =
          std::make_shared<const SurfaceObstacle>(turned(step + 1), ball.triangles, turned(step));
      const Contact contact{.obstacles = {surface}};
      EXPECT_EQ(euler.Advance(state, {.contact = &contact}), IntegratorStatus::kOk) << step;
      EXPECT_GT(SmallestGap(contact, state.x), 0.0) << step;
    }
    double moment = 0.0, inertia = 0.0;
    for (Eigen::Index i = 0; i < state.x.size(); i += 3) {
      moment += state.x[i] * state.v[i + 1] - state.x[i + 1] * state.v[i];
      inertia += state.x.segment<2>(i).squaredNorm();
    }
    return moment / inertia;
  };
  EXPECT_NEAR(angular_speed(0.6), 2 * M_PI, 0.15 * 2 * M_PI);
  EXPECT_LT(angular_speed(0.0), 0.05 * 2 * M_PI);
}

TEST(ImplicitEuler, PinsFollowTheirPlaces) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -kGravity);
  const auto model =
      std::make_shared<ClothModel>(MakeDisc({.target_vertices = 100}), scene, MakeLaw("smooth"));
  ImplicitEuler euler(model, LinearMaterial(100.0, 1e-5, 0.2), 0.01, {});
  State state = model->RestState();
  Surroundings around;
  around.pins = {{.vertex = 0, .stiffness = 1e4, .place = state.x.head<3>()}};
  for (int step = 0; step < 50; ++step) {
    around.pins[0].place.x() += 0.002;
    ASSERT_EQ(euler.Advance(state, around), IntegratorStatus::kOk);
  }
  EXPECT_LT((state.x.head<3>() - around.pins[0].place).norm(), 2e-3);
  EXPECT_LT(state.x.tail<3>().z(), -0.05);
  EXPECT_EQ(euler.failure().vertex, -1);
}

// A vertex that is drawn to a place far away, in a step that may not iterate.
TEST(ImplicitEuler, AFailureNamesTheVertexWithTheLargestUnbalancedForce) {
  constexpr int kVertex = 17;
  const auto model =
      std::make_shared<ClothModel>(MakeDisc({.target_vertices = 100}), Scene{}, MakeLaw("smooth"));
  ImplicitEuler euler(model, LinearMaterial(100.0, 1e-5, 0.2), 0.01, {.max_iterations = 0});
  State state = model->RestState();
  const Eigen::Vector3d place = state.x.segment<3>(3 * kVertex);
  const Surroundings around{
      .pins = {{.vertex = kVertex, .place = place + Eigen::Vector3d::UnitZ()}}};
  ASSERT_EQ(euler.Advance(state, around), IntegratorStatus::kNotConverged);
  EXPECT_EQ(euler.failure().vertex, kVertex);
  EXPECT_EQ(euler.failure().place, place);
}

// Between two planes that leave no room for its thickness there is no shape without penetration.
TEST(ImplicitEuler, ASheetWithoutRoomIsAFailure) {
  Scene scene;
  scene.contact =
      Contact{.obstacles = {PlaneObstacle{.offset = -1e-4},
                            PlaneObstacle{.normal = -Eigen::Vector3d::UnitZ(), .offset = -1e-4}}};
  const auto model =
      std::make_shared<ClothModel>(MakeDisc({.target_vertices = 100}), scene, MakeLaw("smooth"));
  ImplicitEuler euler(model, LinearMaterial(100.0, 1e-5, 0.2), 0.01, {});
  State state = model->RestState();
  EXPECT_EQ(euler.Advance(state), IntegratorStatus::kNotFinite);
  EXPECT_EQ(euler.failure().vertex, 0);
}

}  // namespace
}  // namespace drape
