// SPDX-License-Identifier: Apache-2.0
// Strips that slide around a cylinder and over the edge of a table, against Euler's rope formula.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth/contact/sheets.h"

namespace drape {
namespace {

using test::kGravity;

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

}  // namespace
}  // namespace drape
