// SPDX-License-Identifier: Apache-2.0
// Equilibria of cloth that touches itself: closed forms, derivatives, that no shape passes through
// itself, and that nothing changes where nothing touches.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/cloth/state.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/mesh/self_intersection.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/statics/stiffness.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth/contact/sheets.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using test::kDensity;
using test::kGravity;
using test::RestingGap;

ActivePairs ListTouches(const ClothModel& model, const Eigen::VectorXd& x) {
  return MakeSelfContact(model).FindActivePairs(x);
}

// A strip that is held at one end above a sheet of the same cloth, which is held where it lies, and
// hangs down onto it: a fold that lies on itself would slide away for want of friction. The strip
// is a little off its lattice and wider than the sheet's edges are long, so that all kinds of pairs
// push.
class LyingStrip : public testing::Test {
 protected:
  LyingStrip() {
    scene_.gravity = Eigen::Vector3d(0.0, 0.0, -kGravity);
    scene_.contact = Contact{.self = true};
    for (double& entry : BendEntries(material_)) entry *= 0.1;
  }
  static std::span<double> BendEntries(MaterialField& material) {
    return {material.bend[0].entries(), kBendEntries};
  }
  std::shared_ptr<const ClothModel> MakeModel() {
    const Mesh sheet = MakeStrip(0.06, 0.03, 12, 7);
    Mesh strip = MakeStrip(kLength, kWidth, 12, 5);
    std::mt19937_64 random(5);
    for (Eigen::Index i = 0; i < strip.rest_x.size(); ++i)
      strip.rest_x[i] += i % 3 == 2 ? kHeight : 2e-4 * SampleNormal(random);
    strip.uv = strip.rest_x.reshaped(3, strip.num_vertices()).topRows<2>();
    Handles handles{.regions = {}};
    for (int i = 0; i < sheet.num_vertices() + strip.num_vertices(); ++i)
      if (i < sheet.num_vertices() || strip.uv(0, i - sheet.num_vertices()) < kHeld)
        handles.vertices.push_back(i);
    scene_.handles = handles;
    first_ = sheet.num_vertices();
    return std::make_shared<ClothModel>(test::Together({sheet, strip}), scene_, MakeLaw("smooth"));
  }
  // Straight from the clamp to the sheet, and along it.
  State Hanging(const Mesh& mesh) const {
    State state{mesh.rest_x, Eigen::VectorXd::Zero(mesh.rest_x.size())};
    for (int i = first_; i < mesh.num_vertices(); ++i)
      state.x[3 * i + 2] = std::max(1e-3, kHeight - 0.3 * std::max(0.0, mesh.uv(0, i) - kHeld));
    return state;
  }
  EquilibriumResult Settle(Backend& backend, const MaterialField& material) const {
    const State start = Hanging(backend.model().mesh);
    const RolloutInput input{&material, &start};
    const RolloutResult fallen =
        backend.Rollouts({&input, 1}, {.h = 0.05, .steps = 20}, nullptr)[0];
    EXPECT_EQ(fallen.status, RolloutStatus::kOk) << ToString(fallen.status);
    return Settle(backend, material, fallen.end.x, {.tolerance = 3e-11});
  }
  static EquilibriumResult Settle(Backend& backend, const MaterialField& material,
                                  const Eigen::VectorXd& x, const EquilibriumOptions& options) {
    const State start{x, Eigen::VectorXd::Zero(x.size())};
    const RolloutInput input{&material, &start};
    return backend.Equilibria({&input, 1}, options)[0];
  }

  static constexpr double kLength = 0.05, kWidth = 0.018, kHeld = 9e-3, kHeight = 6e-3;
  int first_ = 0;  // vertex of the strip
  Scene scene_;
  MaterialField material_ = test::TestMaterial(10.0);
};

TEST_F(LyingStrip, RestsAtTheGapOfItsWeight) {
  const auto model = MakeModel();
  const auto backend = MakeCpuBackend(model, 1);
  const EquilibriumResult rest = Settle(*backend, material_);
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual << " " << rest.iterations;
  EXPECT_EQ(CountSelfIntersections(model->mesh, rest.x), 0);
  EXPECT_GT(SmallestSelfGap(*model, rest.x), 0.0);
  EXPECT_GT(ListTouches(*model, rest.x).size(), 50U);
  StepSolver solver(model);
  EXPECT_TRUE(IsStable(LowestEigenvalues(solver, material_, rest.x, 1)));
  // The handles carry all of the weight.
  double carried = 0.0;
  for (const int i : model->held)
    carried += 1e3 * (model->mesh.rest_x[3 * i + 2] - rest.x[3 * i + 2]);
  const double weight = kDensity * kGravity * model->vertex_area.sum();
  EXPECT_NEAR(carried, weight, 1e-9 * weight);
  // Where the strip lies, off its end.
  double height = 0.0;
  int lying = 0;
  for (int i = 0; i < model->mesh.num_vertices(); ++i) {
    const double u = model->mesh.uv(0, i);
    if (i < first_ || u < kLength - 0.012 || u > kLength - 0.003) continue;
    height += rest.x[3 * i + 2];
    ++lying;
  }
  ASSERT_GT(lying, 8);
  const double gap = RestingGap(*scene_.contact, kDensity * kGravity);
  EXPECT_NEAR(height / lying, scene_.contact->thickness + gap, 0.15 * scene_.contact->range);
}

// Neither in the time steps nor in those of Newton's method, whichever is the last.
TEST_F(LyingStrip, DoesNotPassThroughItselfOnTheWay) {
  const auto backend = MakeCpuBackend(MakeModel(), 1);
  const Mesh& mesh = backend->model().mesh;
  const State start = Hanging(mesh);
  const RolloutInput input{&material_, &start};
  for (const int steps : {1, 3, 5, 10, 20}) {
    const auto fallen = backend->Rollouts({&input, 1}, {.h = 0.1, .steps = steps}, nullptr)[0];
    EXPECT_EQ(fallen.status, RolloutStatus::kOk) << steps;
    EXPECT_EQ(CountSelfIntersections(mesh, fallen.end.x), 0) << steps;
    EXPECT_GT(SmallestSelfGap(backend->model(), fallen.end.x), 0.0) << steps;
  }
  for (int iterations = 1; iterations < 40; iterations += 3) {
    const Eigen::VectorXd x =
        Settle(*backend, material_, start.x, {.max_iterations = iterations}).x;
    EXPECT_EQ(CountSelfIntersections(mesh, x), 0) << iterations;
    EXPECT_GT(SmallestSelfGap(backend->model(), x), 0.0) << iterations;
  }
}

// Whatever the same solver has done before.
TEST_F(LyingStrip, HasTheSameBitsTwice) {
  const auto backend = MakeCpuBackend(MakeModel(), 1);
  const EquilibriumResult first = Settle(*backend, material_);
  MaterialField stiffer = material_;
  for (double& entry : BendEntries(stiffer)) entry *= 1.5;
  Settle(*backend, stiffer);
  EXPECT_EQ(Settle(*backend, material_).x, first.x);
  const auto other = MakeCpuBackend(MakeModel(), 1);
  EXPECT_EQ(Settle(*other, material_).x, first.x);
}

// All 39 columns against central differences of equilibria that are solved again, and the adjoint.
TEST_F(LyingStrip, ImplicitDerivativesAreDifferences) {
  const auto model = MakeModel();
  const auto backend = MakeCpuBackend(model, 1);
  const EquilibriumResult rest = Settle(*backend, material_);
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  const State at{rest.x, Eigen::VectorXd::Zero(rest.x.size())};
  const RolloutInput input{&material_, &at};
  const std::vector<const MaterialField*> weights = {&material_};
  const RowMatrix tangent = backend->EquilibriumTangents({&input, 1}, weights)[0];
  ASSERT_EQ(tangent.cols(), kMaterialEntries);
  const auto solve = [&](int k, double step) {
    MaterialField moved = material_;
    (k < kStretchEntries ? moved.stretch[0].entries()[k]
                         : moved.bend[0].entries()[k - kStretchEntries]) *= std::exp(step);
    const EquilibriumResult result = Settle(*backend, moved, rest.x + step * tangent.col(k),
                                            {.tolerance = 1e-13, .max_iterations = 8});
    EXPECT_LT(result.residual, 3e-11) << "entry " << k << " step " << step;
    return result.x;
  };
  const double largest = tangent.colwise().norm().maxCoeff();
  int reached = 0;
  for (int k = 0; k < kMaterialEntries; ++k) {
    const double size = tangent.col(k).norm();
    if (size < 1e-6 * largest) continue;
    ++reached;
    double best = 1.0;
    for (const double step : {1e-4, 1e-3, 1e-5}) {
      const Eigen::VectorXd difference = (solve(k, step) - solve(k, -step)) / (2 * step);
      best = std::min(best, (difference - tangent.col(k)).norm() / size);
      if (best < 1e-6) break;
    }
    EXPECT_LT(best, 1e-6) << "entry " << k;
  }
  EXPECT_GE(reached, 10);
  std::mt19937_64 random(4);
  const RowMatrix seeds = test::RandomMatrix(model->num_dofs(), 3, random);
  const auto gradient = backend->EquilibriumAdjoints({&input, 1}, {&seeds, 1})[0];
  ASSERT_TRUE(gradient);
  const RowMatrix by_tangent = tangent.transpose() * seeds;
  EXPECT_LT((gradient->Contract(material_) - by_tangent).norm(), 1e-9 * by_tangent.norm());
}

// Steps of cloth in contact are filtered, which has no derivative, and a start that overlaps itself
// is none.
TEST_F(LyingStrip, RefusesWhatItCannotDo) {
  const auto model = MakeModel();
  StepSolver solver(model);
  const State start = Hanging(model->mesh);
  Recording recording;
  EXPECT_EQ(Rollout(solver, material_, start, {.steps = 40}, &recording).status,
            RolloutStatus::kBlocked);
  EXPECT_EQ(RolloutTangent(solver, material_, material_, start, {.steps = 40}).rollout.status,
            RolloutStatus::kBlocked);
  State through = start, near = start;
  for (int i = first_; i < model->mesh.num_vertices(); ++i) {
    if (model->mesh.uv(0, i) > 0.04) through.x[3 * i + 2] *= -1.0;
    if (model->mesh.uv(0, i) > 0.04) near.x[3 * i + 2] = 1e-4;
  }
  EXPECT_FALSE(FindSelfOverlap(*model, start.x));
  ASSERT_TRUE(FindSelfOverlap(*model, through.x));
  EXPECT_EQ(FindSelfOverlap(*model, through.x)->distance, 0.0);
  EXPECT_EQ(Rollout(solver, material_, through, {.steps = 1}).status, RolloutStatus::kOverlaps);
  const EquilibriumResult rest = SolveEquilibrium(solver, material_, through.x, {});
  EXPECT_EQ(rest.status, EquilibriumStatus::kNotConverged);
  EXPECT_EQ(rest.iterations, 0);
  ASSERT_TRUE(FindSelfOverlap(*model, near.x));
  EXPECT_NEAR(FindSelfOverlap(*model, near.x)->distance, 1e-4, 1e-5);
}

// A stack on a plane, each sheet kept from sliding by weak springs at three vertices: the layer
// below a sheet carries what is above it, by a force to rounding and by a gap within the change of
// the pressure of two meshes that lie askew.
TEST(LayersAtRest, AStackCarriesItsWeight) {
  constexpr int kSheets = 3;
  constexpr double kSide = 0.04, kSpring = 1e-2;
  Contact surface{.obstacles = {PlaneObstacle{}}, .self = true};
  std::vector<Mesh> sheets;
  std::vector<int> begin = {0}, held;
  double height = 0.5 * surface.thickness;
  std::vector<double> heights;
  for (int k = 0; k < kSheets; ++k) {
    height += RestingGap(surface, kDensity * kGravity * (kSheets - k)) +
              (k > 0 ? surface.thickness : 0.0);
    heights.push_back(height);
    Mesh sheet = MakeStrip(kSide, kSide, 4 + k % 2, 5);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.4 * k + 0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    for (Eigen::Index i = 0; i < sheet.rest_x.size(); i += 3)
      sheet.rest_x.segment<3>(i) =
          turn * (sheet.rest_x.segment<3>(i) - Eigen::Vector3d(0.5 * kSide, 0.0, -2e-3 * (k + 1)));
    for (const int i : {0, 2, sheet.num_vertices() - 1}) held.push_back(begin.back() + i);
    begin.push_back(begin.back() + sheet.num_vertices());
    sheets.push_back(std::move(sheet));
  }
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -kGravity);
  scene.handles = Handles{.regions = {}, .vertices = held, .stiffness = kSpring};
  scene.contact = surface;
  const auto model = std::make_shared<ClothModel>(test::Together(sheets), scene, MakeLaw("smooth"));
  StepSolver solver(model);
  const MaterialField material = LinearMaterial(200.0, 1e-4, kDensity);
  // At rest they are further apart: what is near there does not push.
  Eigen::VectorXd start = model->mesh.rest_x;
  for (int k = 0; k < kSheets; ++k)
    for (int i = begin[k]; i < begin[k + 1]; ++i) start[3 * i + 2] = heights[k];
  const EquilibriumResult rest = SolveEquilibrium(solver, material, start, {.tolerance = 1e-12});
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  const auto mean_height = [&](int k) {
    double sum = 0.0;
    for (int i = begin[k]; i < begin[k + 1]; ++i) sum += rest.x[3 * i + 2];
    return sum / (begin[k + 1] - begin[k]);
  };
  for (int k = 1; k < kSheets; ++k) {
    double up = 0.0, carried = 0.0;
    for (const ActivePair& touch : ListTouches(*model, rest.x)) {
      double share = 0.0;  // of the force on the sheets from k on
      for (int i = 0; i < 4; ++i)
        if (touch.pair.vertex[i] >= begin[k]) share += touch.distance.weight[i];
      up += share * NormalForce(touch) * touch.distance.normal.z();
    }
    for (int i = begin[k]; i < begin[kSheets]; ++i)
      carried += kDensity * kGravity * model->vertex_area[i];
    for (const int i : held)
      if (i >= begin[k]) carried += kSpring * (rest.x[3 * i + 2] - model->mesh.rest_x[3 * i + 2]);
    EXPECT_NEAR(up, carried, 1e-9 * carried) << k;
    EXPECT_NEAR(mean_height(k) - mean_height(k - 1) - surface.thickness,
                RestingGap(surface, kDensity * kGravity * (kSheets - k)), 0.15 * surface.range)
        << k;
  }
}

// Springs whose rest is on the other side of the lower sheet; a step reaches there.
TEST(LayersAtRest, NewtonsStepsDoNotPassThroughASheet) {
  const Mesh lower = MakeStrip(0.04, 0.04, 4, 5);
  Mesh upper = MakeStrip(0.03, 0.03, 5, 6);
  for (Eigen::Index i = 0; i < upper.rest_x.size(); i += 3)
    upper.rest_x.segment<3>(i) += Eigen::Vector3d(3e-3, 1e-3, -5e-3);
  const Mesh both = test::Together({lower, upper});
  Scene scene;
  scene.handles = Handles{.regions = {DiscRegion{.radius = 1.0}}, .stiffness = 1e-3};
  scene.contact = Contact{.self = true};
  const auto model = std::make_shared<ClothModel>(both, scene, MakeLaw("smooth"));
  StepSolver solver(model);
  Eigen::VectorXd start = both.rest_x;
  for (Eigen::Index i = lower.rest_x.size(); i < start.size(); i += 3) start[i + 2] = 3e-3;
  const EquilibriumResult end = SolveEquilibrium(solver, LinearMaterial(200.0, 1e-5, kDensity),
                                                 start, {.first_radius = 0.02});
  EXPECT_EQ(end.status, EquilibriumStatus::kStable) << end.residual;
  const auto heights = end.x.reshaped(3, both.num_vertices()).row(2);
  EXPECT_GT(heights.tail(upper.num_vertices()).mean(), heights.head(lower.num_vertices()).mean());
  EXPECT_EQ(CountSelfIntersections(both, end.x), 0);
}

// A large specimen of a very soft cloth, whose folds pass through one another unless they touch.
TEST(LayersAtRest, FoldsOfASoftDrapeTouch) {
  const MaterialField material = LinearMaterial(200.0, 3e-9, 0.3);
  const EquilibriumOptions exact{.tolerance = 5e-12};
  const auto make = [](ContactModel contact) {
    return MakeCpuBackend(
        std::make_shared<ClothModel>(MakeDisc({.radius = 0.2, .target_vertices = 400}),
                                     CusickScene({contact}), MakeLaw("smooth")),
        1);
  };
  const auto drape = [&](Backend& backend) {
    State start = backend.model().RestState();
    start.x = ApplyStartShape(backend.model().mesh, DiscRegion().radius, RandomStartShape(1, 5e-3));
    const RolloutInput input{&material, &start};
    const State relaxed = backend.Rollouts({&input, 1}, {.h = 0.05, .steps = 100}, nullptr)[0].end;
    const RolloutInput settling{&material, &relaxed};
    return backend.Equilibria({&settling, 1}, exact)[0];
  };
  const auto without = make(ContactModel::kSupport), with = make(ContactModel::kSelf);
  const Mesh& mesh = with->model().mesh;
  EXPECT_GT(CountSelfIntersections(mesh, drape(*without).x), 0);
  const EquilibriumResult rest = drape(*with);
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  EXPECT_EQ(CountSelfIntersections(mesh, rest.x), 0);
  ASSERT_GT(ListTouches(with->model(), rest.x).size(), 4U);
  // By the logarithm of all entries.
  const State at{rest.x, Eigen::VectorXd::Zero(rest.x.size())};
  const RolloutInput input{&material, &at};
  const std::vector<const MaterialField*> weights = {&material};
  const Eigen::VectorXd column = with->EquilibriumTangents({&input, 1}, weights)[0].rowwise().sum();
  const auto scaled = [&](double step) {
    MaterialField moved = material;
    for (double& entry : std::span(moved.stretch[0].entries(), kStretchEntries))
      entry *= std::exp(step);
    for (double& entry : std::span(moved.bend[0].entries(), kBendEntries)) entry *= std::exp(step);
    const State start{rest.x + step * column, Eigen::VectorXd::Zero(rest.x.size())};
    const RolloutInput near{&moved, &start};
    return with->Equilibria({&near, 1}, exact)[0].x;
  };
  constexpr double kStep = 1e-4;
  const Eigen::VectorXd difference = (scaled(kStep) - scaled(-kStep)) / (2 * kStep);
  EXPECT_LT((difference - column).norm(), 1e-6 * column.norm());
}

// A drape that does not touch itself.
TEST(LayersAtRest, NothingThatTouchesChangesNoBit) {
  const MaterialField material = test::TestMaterial();
  const auto make = [](ContactModel contact) {
    return MakeCpuBackend(std::make_shared<ClothModel>(MakeDisc({.target_vertices = 300}),
                                                       CusickScene({contact}), MakeLaw("smooth")),
                          1);
  };
  const auto with = make(ContactModel::kSelf), without = make(ContactModel::kSupport);
  State start = with->model().RestState();
  start.x = ApplyStartShape(with->model().mesh, DiscRegion().radius, RandomStartShape(3, 5e-3));
  const RolloutInput input{&material, &start};
  const std::vector<const MaterialField*> weights = {&material};
  const auto fall = [&](Backend& backend) {
    return backend.Tangents({&input, 1}, weights, {.h = 0.1, .steps = 20})[0];
  };
  const TangentResult a = fall(*with), b = fall(*without);
  ASSERT_EQ(a.rollout.status, RolloutStatus::kOk);
  EXPECT_EQ(a.rollout.end.x, b.rollout.end.x);
  EXPECT_EQ(a.dx, b.dx);
  const RolloutInput fallen{&material, &b.rollout.end};
  const EquilibriumResult rest = with->Equilibria({&fallen, 1}, {})[0],
                          same = without->Equilibria({&fallen, 1}, {})[0];
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  EXPECT_EQ(rest.x, same.x);
}

}  // namespace
}  // namespace drape
