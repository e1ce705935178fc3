// SPDX-License-Identifier: Apache-2.0
// Implicit Euler with contact and friction: a sheet on a slope, and on a turning ball.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth/contact/sheets.h"
#include "tests/physics/simulation/closed_forms.h"

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

// Strips that slide around a cylinder and over the edge of a table, against Euler's rope formula.

constexpr double kPullStep = 0.01;  // [s]

// The strip bent to a curve in the plane y = 0: its point at u is at curve(u).
State Bent(const ClothModel& model, const std::function<Eigen::Vector3d(double)>& curve) {
  State state = model.RestState();
  for (int i = 0; i < model.mesh.num_vertices(); ++i)
    state.x.segment<3>(3 * i) =
        curve(model.mesh.uv(0, i)) + model.mesh.uv(1, i) * Eigen::Vector3d::UnitY();
  return state;
}

// The tension of a limp strip that is drawn over a cylinder, by the dead load at its other end.
double RatioOfTensions(double friction, double angle) {
  constexpr double kLength = 0.3, kHanging = 0.1, kRadius = 0.05, kLoad = 0.02, kSpeed = 0.05;
  Scene scene;
  scene.load = EdgeLoad{HalfPlaneRegion{-Eigen::Vector3d::UnitX(), -kLength},
                        Eigen::Vector3d(0.0, 0.0, -kLoad)};
  scene.contact = Contact{
      .thickness = 0.0,
      .obstacles = {CapsuleObstacle{.from = {0, -1, 0}, .to = {0, 1, 0}, .radius = kRadius}}};
  const auto model =
      std::make_shared<ClothModel>(MakeStrip(kLength, 0.02, 75, 3), scene, MakeLaw("smooth"));
  ImplicitEuler euler(model, LinearMaterial(2000.0, 1e-9, 0.1), kPullStep,
                      {.tolerance = 1e-5, .friction = friction, .friction_change = 1e-3});
  const double radius = kRadius + 0.6 * scene.contact->range;
  const Eigen::Vector3d away(-std::sin(angle), 0.0, std::cos(angle));  // along which it is drawn
  State state = Bent(*model, [&](double u) -> Eigen::Vector3d {
    const double from_load = kLength - u;
    if (from_load < kHanging) return {radius, 0.0, from_load - kHanging};
    const double turn = std::min((from_load - kHanging) / radius, angle);
    const double left = from_load - kHanging - radius * turn;
    return radius * Eigen::Vector3d(std::cos(turn), 0.0, std::sin(turn)) + left * away;
  });
  Surroundings around;
  for (int i = 0; i < model->mesh.num_vertices(); ++i)
    if (model->mesh.uv(0, i) < 1e-9)
      around.pins.push_back({.vertex = i, .place = state.x.segment<3>(3 * i)});
  double tension = 0.0;
  for (int step = 0; step < 60; ++step) {
    for (Pin& pin : around.pins) pin.place += kPullStep * kSpeed * away;
    EXPECT_EQ(euler.Advance(state, around), IntegratorStatus::kOk) << step;
    tension = 0.0;
    for (const Pin& pin : around.pins)
      tension += pin.stiffness * (pin.place - state.x.segment<3>(3 * pin.vertex)).dot(away);
  }
  return tension / kLoad;
}

TEST(StripFriction, ACapstanMultipliesTheTensionByItsAngle) {
  EXPECT_NEAR(RatioOfTensions(0.0, M_PI), 1.0, 2e-3);
  EXPECT_NEAR(RatioOfTensions(0.2, M_PI / 2), std::exp(0.2 * M_PI / 2), 0.02 * 1.369);
  EXPECT_NEAR(RatioOfTensions(0.3, M_PI), std::exp(0.3 * M_PI), 0.02 * 2.566);
}

// A strip of which the length `lying` is on a table and `hanging` below its round edge, which it
// follows on a quarter of a circle of this radius: its speed a second after it was laid so.
double SlidingSpeed(double friction, double lying, double hanging, double radius) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -kGravity);
  // So large that its border is straight across the strip.
  const double gap = 4e-4;
  scene.contact = Contact{.thickness = 0.0,
                          .obstacles = {PlateObstacle{.top = {-1.0, 0.0, 0.0},
                                                      .radius = 1.0,
                                                      .thickness = 3.0 * radius,
                                                      .rim_radius = radius - gap}}};
  const double arc = 0.5 * M_PI * radius, length = lying + arc + hanging;
  const int along = static_cast<int>(std::lround(length / 4e-3));
  const auto model =
      std::make_shared<ClothModel>(MakeStrip(length, 0.01, along, 2), scene, MakeLaw("smooth"));
  ImplicitEuler euler(model, LinearMaterial(5000.0, 1e-9, 0.2), kPullStep,
                      {.tolerance = 1e-6, .friction = friction});
  const Eigen::Vector3d edge(gap - radius, 0.0, gap - radius);  // the centre of the circle
  State state = Bent(*model, [&](double u) -> Eigen::Vector3d {
    if (u < lying) return edge + Eigen::Vector3d(u - lying, 0.0, radius);
    if (u > lying + arc) return edge + Eigen::Vector3d(radius, 0.0, lying + arc - u);
    const double turn = (u - lying) / radius;
    return edge + radius * Eigen::Vector3d(std::sin(turn), 0.0, std::cos(turn));
  });
  for (int step = 0; step < 100; ++step)
    EXPECT_EQ(euler.Advance(state), IntegratorStatus::kOk) << step;
  return state.v.head<3>().norm();  // of a corner that lies
}

// T' = μ(T + ρgR cos φ) − ρgR sin φ along the edge, from T = μρg·lying at φ = 0 to ρg·hanging at
// π/2. With R = 0 the share that may hang is μ/(μ + exp(−μπ/2)).
TEST(StripFriction, AStripSlipsOverAnEdgeWhenTooMuchOfItHangs) {
  constexpr double kFriction = 0.3, kLying = 0.3, kRadius = 0.015;
  const double growth = std::exp(0.5 * M_PI * kFriction), square = kFriction * kFriction;
  const double most = kFriction * kLying * growth +
                      kRadius * (2.0 * kFriction - (1.0 - square) * growth) / (1.0 + square);
  EXPECT_NEAR(kFriction * growth / (1.0 + kFriction * growth), 0.325, 5e-4);  // where R = 0
  EXPECT_LT(SlidingSpeed(kFriction, kLying, 0.98 * most, kRadius), 1.1e-3);
  EXPECT_GT(SlidingSpeed(kFriction, kLying, 1.02 * most, kRadius), 1e-2);
}

// The fold of a strip on a floor whose ends were moved together.

// The height of a free fold in small deflection, where the heavy beam w'''' + p²w'' = −1/ℓ³ lifts
// off with w = w' = w'' = 0 at both ends: tan(pL/2) = pL/2, w = 1.3256·Δ^(4/7)·ℓ^(3/7) with ℓ³ =
// D/ρg and Δ the way by which the ends were moved together [Vella 2009].
TEST(Ruck, HasTheHeightOfAHeavyBeam) {
  constexpr double kRigidity = 1e-5, kLength = 0.14;
  const double elastic = std::cbrt(kRigidity / (test::kDensity * test::kGravity));  // ℓ [m]
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -test::kGravity);
  scene.contact = Contact{.thickness = 0.0, .range = 2e-5, .obstacles = {PlaneObstacle{}}};
  const auto model =
      std::make_shared<ClothModel>(MakeStrip(kLength, 6e-3, 112, 5), scene, MakeLaw("smooth"));
  ImplicitEuler euler(model, LinearBeam(1e5, kRigidity, test::kDensity), 0.05, {.tolerance = 1e-7});
  for (const double share : {0.01, 0.02}) {
    const double moved = share * elastic;
    State state = model->RestState();
    Surroundings around;
    // From a low fold in the middle of a strip that is compressed evenly.
    for (int i = 0; i < model->mesh.num_vertices(); ++i) {
      const double u = model->mesh.uv(0, i);
      state.x[3 * i] -= moved * (u / kLength - 0.5);
      const double from_middle = std::min(std::abs(u - 0.5 * kLength) / (1.5 * elastic), 1.0);
      state.x[3 * i + 2] = 1.8e-5 + 1e-3 * std::pow(std::cos(0.5 * M_PI * from_middle), 2);
      if (u < 1e-9 || u > kLength - 1e-9)
        around.pins.push_back({.vertex = i, .stiffness = 1e5, .place = state.x.segment<3>(3 * i)});
    }
    for (int step = 0; step < 60; ++step)
      ASSERT_EQ(euler.Advance(state, around), IntegratorStatus::kOk) << step;
    EXPECT_LT(state.v.cwiseAbs().maxCoeff(), 1e-4);
    double height = 0.0;
    for (Eigen::Index i = 2; i < state.x.size(); i += 3) height = std::max(height, state.x[i]);
    height -= state.x[2];
    const double expected = 1.3256 * std::pow(moved, 4.0 / 7.0) * std::pow(elastic, 3.0 / 7.0);
    EXPECT_NEAR(height, expected, 0.03 * expected) << share;
  }
}

}  // namespace
}  // namespace drape
