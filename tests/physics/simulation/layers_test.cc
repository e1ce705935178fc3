// SPDX-License-Identifier: Apache-2.0
// Cloth that touches itself. In each shape that Newton's method accepts all gaps are positive; by
// exact predicates no face meets another after a step; and a repeated run has the same bits.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "physics/cloth/contact/surface_contact.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth/contact/sheets.h"

namespace drape {
namespace {

using test::kDensity;
using test::kGravity;
using test::Square;

std::shared_ptr<const ClothModel> Falling(Mesh mesh, double gravity,
                                          const std::optional<Contact>& contact = {}) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -gravity);
  scene.contact = contact;
  return std::make_shared<ClothModel>(std::move(mesh), scene, MakeLaw("smooth"));
}

Mesh Moved(Mesh mesh, const Eigen::Vector3d& by) {
  for (Eigen::Index i = 0; i < mesh.rest_x.size(); i += 3) mesh.rest_x.segment<3>(i) += by;
  return mesh;
}

Mesh Turned(Mesh mesh, const Eigen::Matrix3d& turn) {
  mesh.rest_x = (turn * mesh.rest_x.reshaped(3, mesh.num_vertices())).reshaped();
  return mesh;
}

// Cloth that moves under what is done to it in each step.
struct Layers {
  std::shared_ptr<const ClothModel> model;
  State state = {};
  MaterialField material = LinearMaterial(200.0, 5e-6, kDensity);
  double h = 0.01;
  int steps = 100;
  int repeated = 0;  // first steps that a second run makes with the same bits
  ImplicitEulerOptions options = {
      .tolerance = 1e-6, .friction = 0.3, .self_friction = 0.3, .self_contact = Contact{}};
  std::function<std::vector<Pin>(int step)> pins = [](int) { return std::vector<Pin>(); };
  std::function<void(const State& before, const State& after)> check = [](const State&,
                                                                          const State&) {};
};

// Makes the repeated steps again, without a look at what is accepted.
void ExpectSameBits(const Layers& run, const State& then) {
  ImplicitEulerOptions options = run.options;
  options.on_accept = {};
  ImplicitEuler euler(run.model, run.material, run.h, options);
  State state = run.state;
  for (int step = 0; step < run.repeated; ++step)
    ASSERT_EQ(euler.Advance(state, {.pins = run.pins(step)}), IntegratorStatus::kOk);
  EXPECT_EQ(state.x, then.x);
  EXPECT_EQ(state.v, then.v);
}

// Checks each accepted shape and each step. `least_touches`: a tenth of the steps have as many
// pairs.
State RunLayers(Layers& run, std::size_t least_touches) {
  const ClothModel& model = *run.model;
  SurfaceContact watcher(model.mesh, model.vertex_area, *run.options.self_contact);
  Eigen::VectorXd none = Eigen::VectorXd::Zero(model.num_dofs());
  run.options.on_accept = [&](const Eigen::VectorXd& x) {
    LimitStep(watcher, x, none);
    EXPECT_GT(watcher.SmallestGap(x), 0.0);
  };
  ImplicitEuler euler(run.model, run.material, run.h, run.options);
  const auto triangles = ListTriangles(model.mesh);
  State state = run.state, then;
  int touching = 0;
  for (int step = 0; step < run.steps; ++step) {
    const State before = state;
    EXPECT_EQ(euler.Advance(state, {.pins = run.pins(step)}), IntegratorStatus::kOk) << step;
    EXPECT_TRUE(FindSelfIntersections(triangles, state.x).empty()) << step;
    run.check(before, state);
    if (testing::Test::HasFailure()) return state;
    LimitStep(watcher, state.x, none);
    touching += watcher.FindActivePairs(state.x).size() >= least_touches;
    if (step + 1 == run.repeated) then = state;
  }
  EXPECT_GT(10 * touching, run.steps);
  if (run.repeated > 0) ExpectSameBits(run, then);
  return state;
}

TEST(Layers, SheetsThatCollideConserveMomentum) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.2, 0.1, 1.0).normalized()).toRotationMatrix();
  const Mesh one = Square(0.1, 5), other = Moved(Turned(Square(0.1, 6), turn), {0.02, 0.01, 0.03});
  Layers run{.model = Falling(test::Together({one, other}), 0.0)};
  run.state = run.model->RestState();
  for (int i = one.num_vertices(); i < run.model->mesh.num_vertices(); ++i)
    run.state.v.segment<3>(3 * i) << 0.2, -0.3, -1.5;
  run.options.tolerance = 1e-10;
  run.options.self_friction = 0.0;  // which turns layers about the gap between them
  run.h = 5e-3;
  run.steps = 30;
  const Eigen::VectorXd mass = run.model->LumpedMass(kDensity);
  double exchanged = 0.0;
  run.check = [&](const State& before, const State& after) {
    const Eigen::VectorXd impulses = mass.cwiseProduct(after.v - before.v);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), moment = sum, of_one = sum;
    for (int i = 0; 3 * i < impulses.size(); ++i) {
      const Eigen::Vector3d impulse = impulses.segment<3>(3 * i);
      sum += impulse;
      // Forces act at the places after the step.
      moment += Eigen::Vector3d(after.x.segment<3>(3 * i)).cross(impulse);
      if (i < one.num_vertices()) of_one += impulse;
    }
    EXPECT_LT(sum.norm(), 1e-10);
    EXPECT_LT(moment.norm(), 1e-11);
    exchanged = std::max(exchanged, of_one.norm());
  };
  RunLayers(run, 10);
  EXPECT_GT(exchanged, 1e-4);
}

// Each interface of a stack carries the weight above it, at the gap of that pressure.
TEST(Layers, AStackRestsWithTheGapsOfItsWeight) {
  constexpr int kSheets = 4;
  constexpr double kSide = 0.06;
  const Contact surface;
  std::vector<Mesh> sheets;
  std::vector<int> begin;
  int vertices = 0;
  for (int k = 0; k < kSheets; ++k) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.4 * k, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    sheets.push_back(Moved(Turned(Square(kSide, 4 + k % 2), turn), {0.0, 0.0, 1e-3 * (k + 1)}));
    begin.push_back(vertices);
    vertices += sheets.back().num_vertices();
  }
  Contact floor = surface;
  floor.obstacles = {PlaneObstacle{}};
  Layers run{.model = Falling(test::Together(sheets), kGravity, floor)};
  run.state = run.model->RestState();
  run.material = LinearMaterial(200.0, 1e-4, kDensity);  // stiff, so that the sheets are flat
  run.h = 0.02;
  run.steps = 80;
  const State rest = RunLayers(run, 50);
  EXPECT_LT(rest.v.cwiseAbs().maxCoeff(), 1e-3);
  std::vector<double> heights;
  begin.push_back(vertices);
  for (int k = 0; k < kSheets; ++k) {
    double sum = 0.0;
    for (int i = begin[k]; i < begin[k + 1]; ++i) sum += rest.x[3 * i + 2];
    heights.push_back(sum / (begin[k + 1] - begin[k]));
  }
  for (int k = 0; k < kSheets; ++k) {
    const double pressure = kDensity * kGravity * (kSheets - k);
    const double gap = k == 0 ? heights[0] - 0.5 * surface.thickness
                              : heights[k] - heights[k - 1] - surface.thickness;
    double low = 0.0, high = surface.range;  // of the gap with that pressure
    while (high - low > 1e-12) {
      const double middle = 0.5 * (low + high);
      const double pushes = -surface.stiffness * EvaluateBarrier(middle, surface.range).slope;
      (pushes > pressure ? low : high) = middle;
    }
    EXPECT_NEAR(gap, low, (k == 0 ? 0.01 : 0.15) * surface.range) << k;
  }
}

// A strip whose ends turn against one another until it is wound up.
TEST(Layers, ATwistedStripDoesNotPassThroughItself) {
  constexpr double kLength = 0.2, kWidth = 0.05;
  constexpr int kSteps = 100;
  Layers run{.model = Falling(MakeStrip(kLength, kWidth, 16, 5), 0.0)};
  run.state = run.model->RestState();
  run.steps = kSteps;
  run.repeated = 70;
  const Mesh& mesh = run.model->mesh;
  run.pins = [&](int step) {
    std::vector<Pin> pins;
    const double turn = 2.0 * M_PI * 2.0 * (step + 1) / kSteps;  // of each end
    const double nearer = 0.12 * kLength * (step + 1) / kSteps;
    for (int i = 0; i < mesh.num_vertices(); ++i) {
      const Eigen::Vector3d rest = mesh.rest_x.segment<3>(3 * i);
      const bool left = rest.x() < 1e-9;
      if (!left && rest.x() < kLength - 1e-9) continue;
      const double angle = left ? -turn : turn;
      pins.push_back({.vertex = i,
                      .stiffness = 1e3,
                      .place = {left ? nearer : rest.x() - nearer, rest.y() * std::cos(angle),
                                rest.y() * std::sin(angle)}});
    }
    return pins;
  };
  RunLayers(run, 20);
}

// Sheets that fall on one another and on the floor, askew.
TEST(Layers, AFallingPileDoesNotPassThroughItself) {
  std::vector<Mesh> sheets;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(0.9 * k, Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(0.3 * (k % 2 == 0 ? 1 : -1), Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    sheets.push_back(Moved(Turned(Square(0.1, 6), turn), {0.005 * k, 0.0, 0.02 + 0.035 * k}));
  }
  Layers run{
      .model = Falling(test::Together(sheets), kGravity, Contact{.obstacles = {PlaneObstacle{}}})};
  run.state = run.model->RestState();
  run.steps = 60;
  run.repeated = 25;
  RunLayers(run, 50);
}

// A band cut as a U that opens to the left: two legs, 14 mm apart at the neck and 40 mm at the
// bend.
Mesh MakeBight(double length) {
  constexpr double kNeck = 7e-3, kBend = 20e-3, kCentre = 15e-3, kCell = 4e-3;
  std::vector<Eigen::Vector2d> centre;
  for (double x = -length; x < kCentre; x += kCell) {
    const double share = std::clamp((x + kCentre) / (2.0 * kCentre), 0.0, 1.0);
    centre.push_back({x, kNeck + (kBend - kNeck) * share * share * (3.0 - 2.0 * share)});
  }
  const std::size_t leg = centre.size();
  constexpr int kArc = 16;
  for (int k = 0; k <= kArc; ++k) {
    const double angle = M_PI * (0.5 - double(k) / kArc);
    centre.push_back({kCentre + kBend * std::cos(angle), kBend * std::sin(angle)});
  }
  for (std::size_t k = leg; k-- > 0;) centre.push_back({centre[k].x(), -centre[k].y()});
  constexpr int kAcross = 3;
  const auto along = static_cast<int>(centre.size());
  Eigen::Matrix2Xd uv(2, kAcross * along);
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < along; ++i) {
    const Eigen::Vector2d way = centre[std::min(i + 1, along - 1)] - centre[std::max(i - 1, 0)];
    const Eigen::Vector2d left = Eigen::Vector2d(-way.y(), way.x()).normalized();
    for (int k = 0; k < kAcross; ++k) {
      uv.col(kAcross * i + k) = centre[i] + 3e-3 * (k - 1) * left;
      if (i + 1 == along || k + 1 == kAcross) continue;
      const int here = kAcross * i + k;
      triangles.push_back({here, here + kAcross, here + kAcross + 1});
      triangles.push_back({here, here + kAcross + 1, here + 1});
    }
  }
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * uv.cols());
  x.reshaped(3, uv.cols()).topRows<2>() = uv;
  return BuildMesh(x, uv, triangles, "bight");
}

// Two bights, each through the other: the second comes from below through the first, goes over its
// legs, under its neck, and back. Pulled by their ends they jam, and neither comes free.
TEST(Layers, AReefKnotHolds) {
  constexpr double kLength = 80e-3, kPull = 60e-3;
  const Mesh first = MakeBight(kLength);
  Mesh second = Turned(first, Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix());
  for (Eigen::Index i = 0; i < second.rest_x.size(); i += 3) {
    const double share = std::clamp((22e-3 - std::abs(second.rest_x[i])) / 14e-3, 0.0, 1.0);
    second.rest_x[i + 2] = 1.5e-3 * (2.0 * share * share * (3.0 - 2.0 * share) - 1.0);
  }
  Layers run{.model = Falling(test::Together({first, second}), 0.0)};
  const Mesh& mesh = run.model->mesh;
  ASSERT_TRUE(FindSelfIntersections(ListTriangles(mesh), mesh.rest_x).empty());
  run.state = run.model->RestState();
  run.steps = 100;
  run.pins = [&](int step) {
    std::vector<Pin> pins;
    for (int i = 0; i < mesh.num_vertices(); ++i) {
      const Eigen::Vector3d rest = mesh.rest_x.segment<3>(3 * i);
      if (std::abs(rest.x()) < kLength - 1e-9) continue;
      const double moved = std::copysign(kPull * (step + 1) / 100.0, rest.x());
      pins.push_back(
          {.vertex = i, .stiffness = 20.0, .place = rest + Eigen::Vector3d(moved, 0.0, 0.0)});
    }
    return pins;
  };
  const State tight = RunLayers(run, 50);
  const int own = first.num_vertices();
  double bend_of_first = -1.0, bend_of_second = 1.0, ends = 0.0;
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    const double x = tight.x[3 * i];
    if (i < own) bend_of_first = std::max(bend_of_first, x);
    if (i >= own) bend_of_second = std::min(bend_of_second, x);
    ends = std::max(ends, std::abs(x));
  }
  EXPECT_GT(bend_of_first, bend_of_second + 5e-3);  // they still reach through one another
  EXPECT_LT(ends, kLength + kPull - 2e-3);          // and the ends lag behind the hands
}

}  // namespace
}  // namespace drape
