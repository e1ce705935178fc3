// SPDX-License-Identifier: Apache-2.0
// Cloth that is thrown, dragged and pressed against obstacles. In each shape that Newton's method
// accepts no vertex touches an obstacle; by exact predicates no face meets a body; and a repeated
// run, with more threads, has the same bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth/contact/sheets.h"

namespace drape {
namespace {

using test::Square;

std::shared_ptr<const ClothModel> Falling(Mesh mesh) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  return std::make_shared<ClothModel>(std::move(mesh), scene, MakeLaw("smooth"));
}

// What is around the cloth in each step. The obstacles of a step outlive it.
struct Stress {
  std::shared_ptr<const ClothModel> model;
  double h = 0.01;
  int steps = 100;
  int repeated = 0;  // first steps that a run with three threads makes with the same bits
  double friction = 0.4;
  std::function<Contact(int step)> contact = {};
  std::function<std::vector<Pin>(int step)> pins = [](int) { return std::vector<Pin>(); };
  std::function<void(const State&, const Contact&)> check = [](const State&, const Contact&) {};
  std::function<void(const Eigen::VectorXd& x)> accepted = [](const Eigen::VectorXd&) {};
  double least_touching = 0.1;  // of the accepted shapes, those with a vertex in contact
};

void ExpectSameBits(const Stress& stress, const State& then) {
  ImplicitEuler euler(stress.model, LinearMaterial(200.0, 5e-6, 0.2), stress.h,
                      {.tolerance = 1e-5, .friction = stress.friction, .threads = 3});
  State state = stress.model->RestState();
  for (int step = 0; step < stress.repeated; ++step) {
    const Contact now = stress.contact(step);
    ASSERT_EQ(euler.Advance(state, {.contact = &now, .pins = stress.pins(step)}),
              IntegratorStatus::kOk);
  }
  EXPECT_EQ(state.x, then.x);
  EXPECT_EQ(state.v, then.v);
}

State RunStress(const Stress& stress) {
  const Contact* contact = nullptr;
  int accepted = 0, touching = 0;
  ImplicitEulerOptions options{.tolerance = 1e-5, .friction = stress.friction, .threads = 1};
  options.on_accept = [&](const Eigen::VectorXd& x) {
    const double gap = SmallestGap(*contact, x);
    EXPECT_GT(gap, 0.0);
    ++accepted;
    touching += gap < contact->range;
    stress.accepted(x);
  };
  ImplicitEuler euler(stress.model, LinearMaterial(200.0, 5e-6, 0.2), stress.h, options);
  State state = stress.model->RestState(), then;
  for (int step = 0; step < stress.steps; ++step) {
    const Contact now = stress.contact(step);
    contact = &now;
    EXPECT_EQ(euler.Advance(state, {.contact = &now, .pins = stress.pins(step)}),
              IntegratorStatus::kOk)
        << step;
    EXPECT_TRUE(state.x.allFinite()) << step;
    stress.check(state, now);
    if (testing::Test::HasFailure()) return state;
    if (step + 1 == stress.repeated) then = state;
  }
  EXPECT_GT(accepted, stress.steps);
  EXPECT_GE(touching, stress.least_touching * accepted);
  if (stress.repeated > 0) ExpectSameBits(stress, then);
  return state;
}

// Pairs of a face of the cloth and one of the body.
int CountMeetings(const Mesh& mesh, const Eigen::VectorXd& x, const test::ClosedMesh& body) {
  std::vector<std::array<int, 3>> all = ListTriangles(mesh);
  const auto faces = static_cast<int>(all.size());
  for (std::array<int, 3> triangle : body.triangles) {
    for (int& i : triangle) i += mesh.num_vertices();
    all.push_back(triangle);
  }
  Eigen::VectorXd both(x.size() + body.x.size());
  both << x, body.x.reshaped();
  constexpr int kMost = 1000000;  // the cloth passes through itself
  int count = 0;
  for (const auto& [a, b] : FindSelfIntersections(all, both, kMost))
    count += a < faces && b >= faces;
  return count;
}

Eigen::Matrix3d TurnAboutZ(double angle) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return turn;
}

// As Codimensional IPC's, a ball of .3 m that turns by 180° a second from the first second on.
TEST(ContactStress, ATurningBallCarriesASquare) {
  constexpr double kRate = M_PI, kStep = 0.04;
  const test::ClosedMesh ball = test::MakeBall(0.15, 3);
  const auto turned = [&](int step) -> Eigen::Matrix3Xd {
    const Eigen::Matrix3d turn = TurnAboutZ(kRate * kStep * std::max(0, step - 25));
    return (turn * ball.x).colwise() - Eigen::Vector3d(0.0, 0.0, 0.155);
  };
  int frame = 0;
  Stress stress{
      .model = Falling(Square(0.36, 10)), .h = kStep, .steps = 45, .repeated = 10, .friction = 0.4};
  stress.contact = [&](int step) {
    frame = step + 1;
    return Contact{.obstacles = {std::make_shared<const SurfaceObstacle>(
                       turned(step + 1), ball.triangles, turned(step))}};
  };
  stress.check = [&](const State& state, const Contact&) {
    EXPECT_EQ(CountMeetings(stress.model->mesh, state.x, {turned(frame), ball.triangles}), 0)
        << frame;
  };
  const State state = RunStress(stress);
  // Of what lies on top.
  double moment = 0.0, inertia = 0.0;
  for (Eigen::Index i = 0; i < state.x.size(); i += 3) {
    if (state.x.segment<2>(i).norm() > 0.07) continue;
    moment += state.x[i] * state.v[i + 1] - state.x[i + 1] * state.v[i];
    inertia += state.x.segment<2>(i).squaredNorm();
  }
  EXPECT_NEAR(moment / inertia, kRate, 0.1 * kRate);
}

TEST(ContactStress, ATableClothIsDrawnOverTheEdgeOfAPlate) {
  const PlateObstacle plate{.top = {0.0, 0.0, -2e-3}, .radius = 0.12, .rim_radius = 5e-3};
  Stress stress{
      .model = Falling(Square(0.36, 14)), .h = 0.01, .steps = 60, .repeated = 40, .friction = 0.2};
  stress.contact = [&](int) { return Contact{.obstacles = {plate}}; };
  const Mesh& mesh = stress.model->mesh;
  stress.pins = [&](int step) {
    std::vector<Pin> pins;
    for (int i = 0; i < mesh.num_vertices(); ++i) {
      if (mesh.uv(0, i) < 0.36 - 1e-9) continue;
      const Eigen::Vector3d drawn(0.01 * std::max(0, step - 20), 0.0, -0.1);
      pins.push_back({.vertex = i,
                      .stiffness = 20.0,
                      .place = Eigen::Vector3d(mesh.rest_x.segment<3>(3 * i)) + drawn});
    }
    return step < 10 ? std::vector<Pin>() : pins;
  };
  RunStress(stress);
}

// A disc that a thread in its middle draws down through a round funnel. It passes through itself
// there.
TEST(ContactStress, ADiscIsDrawnThroughAFunnel) {
  constexpr double kSpeed = 0.2, kStep = 0.02, kHeight = 0.06;
  const test::ClosedMesh funnel = test::MakeRing(0.09, 0.05, 24, 16);
  const auto surface = std::make_shared<const SurfaceObstacle>(funnel.x, funnel.triangles);
  Mesh disc = MakeDisc({.target_vertices = 130});
  int middle = 0;
  for (int i = 0; i < disc.num_vertices(); ++i)
    if (disc.uv.col(i).norm() < disc.uv.col(middle).norm()) middle = i;
  for (Eigen::Index i = 2; i < disc.rest_x.size(); i += 3) disc.rest_x[i] = kHeight;
  Stress stress{
      .model = Falling(std::move(disc)), .h = kStep, .steps = 45, .repeated = 15, .friction = 0.2};
  stress.contact = [&](int) { return Contact{.obstacles = {surface}}; };
  stress.pins = [&](int step) {
    return std::vector<Pin>{{.vertex = middle,
                             .stiffness = 50.0,
                             .place = {0.0, 0.0, kHeight - kSpeed * kStep * (step + 1)}}};
  };
  stress.check = [&](const State& state, const Contact&) {
    EXPECT_EQ(CountMeetings(stress.model->mesh, state.x, funnel), 0);
  };
  const State state = RunStress(stress);
  EXPECT_LT(state.x(Eigen::seq(2, Eigen::last, 3)).maxCoeff(), 0.0);
}

// A bar that swings to and fro through a curtain that hangs from one edge.
TEST(ContactStress, ABarSwingsIntoACurtain) {
  Mesh curtain = MakeStrip(0.3, 0.3, 12, 14);
  for (int i = 0; i < curtain.num_vertices(); ++i)
    curtain.rest_x.segment<3>(3 * i) << 0.0, curtain.uv(1, i), -curtain.uv(0, i);
  Stress stress{.model = Falling(std::move(curtain)),
                .h = 0.01,
                .steps = 100,
                .repeated = 40,
                .friction = 0.3};
  const Mesh& mesh = stress.model->mesh;
  stress.contact = [&](int step) {
    const double x = 0.25 * std::cos(2 * M_PI * 0.01 * (step + 1));
    return Contact{.obstacles = {CapsuleObstacle{
                       .from = {x, -0.08, -0.22}, .to = {x, 0.1, -0.15}, .radius = 0.03}}};
  };
  stress.pins = [&](int) {
    std::vector<Pin> pins;
    for (int i = 0; i < mesh.num_vertices(); ++i)
      if (mesh.uv(0, i) < 1e-9)
        pins.push_back({.vertex = i, .place = mesh.rest_x.segment<3>(3 * i)});
    return pins;
  };
  RunStress(stress);
}

// Holds the corners of a square.
std::vector<Pin> PinCorners(const Mesh& mesh, double side) {
  std::vector<Pin> pins;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    if (mesh.rest_x.segment<2>(3 * i).cwiseAbs().minCoeff() > 0.5 * side - 1e-9)
      pins.push_back({.vertex = i, .stiffness = 100.0, .place = mesh.rest_x.segment<3>(3 * i)});
  }
  return pins;
}

// A spike that comes up by 4 mm a step through the middle of a face of 6 cm and goes down again.
TEST(ContactStress, ASpikeLiftsACoarseSquare) {
  constexpr double kSide = 0.36;
  const test::ClosedMesh spike = test::MakeWedge(1e-3, 0.02, 0.08);
  const auto moved = [&](int step) -> Eigen::Matrix3Xd {
    const double height = -0.03 + 4e-3 * std::min({step, 20, std::max(0, 50 - step)});
    return spike.x.colwise() + Eigen::Vector3d(0.013, 0.011, height);
  };
  Stress stress{.model = Falling(Square(kSide, 6)), .steps = 60, .repeated = 20, .friction = 0.3};
  const Mesh& mesh = stress.model->mesh;
  int now = 0;
  stress.least_touching = 0.0;
  stress.contact = [&](int step) {
    now = step + 1;
    return Contact{.obstacles = {std::make_shared<const SurfaceObstacle>(
                       moved(now), spike.triangles, moved(step))}};
  };
  stress.pins = [&](int) { return PinCorners(mesh, kSide); };
  double highest = -1.0;
  stress.accepted = [&](const Eigen::VectorXd& x) {
    ASSERT_EQ(CountMeetings(mesh, x, {moved(now), spike.triangles}), 0) << now;
    highest = std::max(highest, x(Eigen::seq(2, Eigen::last, 3)).maxCoeff());
  };
  RunStress(stress);
  EXPECT_GT(highest, 0.03);
}

// A coarse square falls across a knife, which then moves along its edge.
TEST(ContactStress, AKnifeDoesNotCutACoarseSquare) {
  constexpr double kSpeed = 0.1, kStep = 0.01;
  const test::ClosedMesh knife = test::MakeWedge(0.8, 0.01, 0.3);
  const auto moved = [&](int step) -> Eigen::Matrix3Xd {
    return knife.x.colwise() +
           Eigen::Vector3d(kSpeed * kStep * std::max(0, step - 15), 0.011, -0.005);
  };
  const auto speed = [&](double friction) {
    Stress stress{.model = Falling(Square(0.36, 6)), .steps = 30, .friction = friction};
    const Mesh& mesh = stress.model->mesh;
    int now = 0;
    stress.least_touching = 0.0;
    stress.contact = [&](int step) {
      now = step + 1;
      return Contact{.obstacles = {std::make_shared<const SurfaceObstacle>(
                         moved(now), knife.triangles, moved(step))}};
    };
    stress.accepted = [&](const Eigen::VectorXd& x) {
      ASSERT_EQ(CountMeetings(mesh, x, {moved(now), knife.triangles}), 0) << now;
    };
    const State state = RunStress(stress);
    return state.v(Eigen::seq(0, Eigen::last, 3)).mean();
  };
  EXPECT_NEAR(speed(0.6), kSpeed, 0.3 * kSpeed);
  EXPECT_LT(std::abs(speed(0.0)), 0.1 * kSpeed);
}

}  // namespace
}  // namespace drape
