// SPDX-License-Identifier: Apache-2.0
// Cloth that rests on obstacles: closed forms, derivatives, and scenes where nothing touches.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/contact/obstacles/surface_obstacle.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/statics/statics.h"
#include "physics/simulation/textbook.h"
#include "physics/util/math/random.h"
#include "tests/physics/cloth/contact/closed_mesh.h"
#include "tests/physics/cloth/contact/sheets.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using test::RestingGap;

// A sheet that lies on a plane has the gap whose pressure carries its weight by area.
TEST(ContactDrapes, ASheetLiesWhereThePressureIsItsWeight) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  scene.contact = Contact{.obstacles = {PlaneObstacle{}}};
  const auto model =
      std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), scene, MakeLaw("smooth"));
  const MaterialField material = LinearMaterial(100.0, 1e-5, 0.2);
  const double gap = RestingGap(*scene.contact, 0.2 * 9.8);
  EXPECT_NEAR(gap / scene.contact->range, 0.9213, 1e-4);
  const auto lifted = [&](double z) {
    Eigen::VectorXd x = model->mesh.rest_x;
    for (Eigen::Index i = 2; i < x.size(); i += 3) x[i] = z;
    return x;
  };
  const double height = 0.5 * scene.contact->thickness + gap;
  EXPECT_LT(ForceResidual(*model, material, lifted(height)), 1e-12);
  // It may slide on the plane, so K is singular: Newton's method is asked for the height alone.
  StepSolver solver(model);
  const EquilibriumResult rest = SolveEquilibrium(solver, material, lifted(height - 2e-4), {});
  EXPECT_LT(rest.residual, 1e-9);
  for (Eigen::Index i = 2; i < rest.x.size(); i += 3) EXPECT_NEAR(rest.x[i], height, 1e-9);
}

class ContactDrapesTest : public testing::Test {
 protected:
  static std::unique_ptr<Backend> MakeDiscBackend(const Scene& scene) {
    return MakeCpuBackend(
        std::make_shared<ClothModel>(MakeDisc({.target_vertices = 600}), scene, MakeLaw("smooth")),
        1);
  }
  static State Start(const Mesh& mesh) {
    State start{ApplyStartShape(mesh, DiscRegion().radius, RandomStartShape(3, 5e-3)), {}};
    start.v = Eigen::VectorXd::Zero(start.x.size());
    return start;
  }
  static EquilibriumResult Drape(Backend& backend, const MaterialField& material) {
    const State start = Start(backend.model().mesh);
    const RolloutInput input{&material, &start};
    State relaxed = backend.Rollouts({&input, 1}, {.h = 0.1, .steps = 60}, nullptr)[0].end;
    const RolloutInput settling{&material, &relaxed};
    return backend.Equilibria({&settling, 1}, {})[0];
  }

  // So soft and heavy that it hangs straight down from the rim of the support.
  MaterialField soft_ = LinearMaterial(500.0, 5e-8, 0.3);
};

TEST_F(ContactDrapesTest, ObstaclesThatNothingTouchesChangeNoBit) {
  const MaterialField material = test::TestMaterial();
  Scene scene = CusickScene();
  scene.contact = Contact{
      .obstacles = {PlaneObstacle{.offset = -0.5}, SphereObstacle{.centre = {0.0, 0.0, 0.6}}}};
  const auto without = MakeDiscBackend(CusickScene()), with = MakeDiscBackend(scene);
  EXPECT_EQ(Drape(*with, material).x, Drape(*without, material).x);
  const State start = Start(with->model().mesh);
  const RolloutInput input{&material, &start};
  const RolloutOptions options{.h = 0.05, .steps = 10};
  EXPECT_EQ(
      with->Tangents({&input, 1}, std::vector<const MaterialField*>{&material}, options)[0].dx,
      without->Tangents({&input, 1}, std::vector<const MaterialField*>{&material}, options)[0].dx);
}

TEST_F(ContactDrapesTest, ASoftClothStaysOutOfTheSupport) {
  const auto without = MakeDiscBackend(CusickScene());
  const auto with = MakeDiscBackend(CusickScene({ContactModel::kSupport}));
  const Contact& contact = *with->model().scene.contact;
  const EquilibriumResult free = Drape(*without, soft_), rest = Drape(*with, soft_);
  ASSERT_EQ(free.status, EquilibriumStatus::kStable);
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  EXPECT_LT(SmallestGap(contact, free.x), 0.0);
  const double gap = SmallestGap(contact, rest.x);
  EXPECT_GT(gap, 0.0);
  EXPECT_LT(gap, contact.range);
}

// The 39 columns of the implicit derivative and the adjoint, with contact at the rim.
TEST_F(ContactDrapesTest, ImplicitDerivativesAreDifferences) {
  const auto backend = MakeDiscBackend(CusickScene({ContactModel::kSupport}));
  const Contact& contact = *backend->model().scene.contact;
  const EquilibriumOptions exact{.tolerance = 5e-12};
  const auto settle = [&](const MaterialField& material, const Eigen::VectorXd& x) {
    const State start{x, Eigen::VectorXd::Zero(x.size())};
    const RolloutInput input{&material, &start};
    return backend->Equilibria({&input, 1}, exact)[0];
  };
  const EquilibriumResult rest = settle(soft_, Drape(*backend, soft_).x);
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  ASSERT_LT(SmallestGap(contact, rest.x), 0.9 * contact.range);
  const State at{rest.x, Eigen::VectorXd::Zero(rest.x.size())};
  const RolloutInput input{&soft_, &at};
  const std::vector<const MaterialField*> weights = {&soft_};
  const RowMatrix tangent = backend->EquilibriumTangents({&input, 1}, weights)[0];
  ASSERT_EQ(tangent.cols(), kMaterialEntries);
  // All bend entries at once, along which the drape changes the most.
  constexpr double kStep = 1e-4;
  const auto bent = [&](double factor) {
    MaterialField changed = soft_;
    for (int k = 0; k < kBendEntries; ++k) changed.bend[0].entries()[k] *= factor;
    return settle(changed, rest.x).x;
  };
  const Eigen::VectorXd difference = (bent(1 + kStep) - bent(1 - kStep)) / (2 * kStep);
  const Eigen::VectorXd column = tangent.rightCols(kBendEntries).rowwise().sum();
  EXPECT_LT((difference - column).norm(), 1e-6 * column.norm());
  const RowMatrix u = RowMatrix::Random(rest.x.size(), 1);
  const auto gradient = backend->EquilibriumAdjoints({&input, 1}, std::vector<RowMatrix>{u})[0];
  ASSERT_TRUE(gradient);
  double by_adjoint = 0.0;
  for (int k = 0; k < kBendEntries; ++k)
    by_adjoint += gradient->bend(k, 0) * soft_.bend[0].entries()[k];
  EXPECT_NEAR(by_adjoint, (u.transpose() * column)(0), 1e-9 * u.norm() * column.norm());
}

// A cloth thrown onto a sphere from far never enters it, whatever the step.
TEST_F(ContactDrapesTest, StepsDoNotEnterObstacles) {
  for (const double h : {0.01, 0.05, 0.2}) {
    Scene scene;
    scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
    scene.contact = Contact{
        .obstacles = {SphereObstacle{.centre = {0.01, 0.02, -0.2}}, PlaneObstacle{.offset = -0.3}}};
    const auto model =
        std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), scene, MakeLaw("smooth"));
    StepSolver solver(model);
    State state = model->RestState();
    const Eigen::VectorXd mass = model->LumpedMass(soft_.density);
    for (int step = 0; step < 100; ++step) {
      ASSERT_EQ(AdvanceOneStep(solver, soft_, mass, h, state), RolloutStatus::kOk) << h << step;
      ASSERT_GT(SmallestGap(*scene.contact, state.x), 0.0) << h << " " << step;
    }
    EXPECT_LT(SmallestGap(*scene.contact, state.x), scene.contact->range);
  }
}

TEST_F(ContactDrapesTest, ABlockedStepHasNoDerivative) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  scene.contact = Contact{.obstacles = {PlaneObstacle{.offset = -0.01}}};
  const auto model =
      std::make_shared<ClothModel>(MakeDisc({.target_vertices = 100}), scene, MakeLaw("smooth"));
  StepSolver solver(model);
  const RolloutOptions options{.h = 0.1, .steps = 5};
  EXPECT_EQ(Rollout(solver, soft_, model->RestState(), options).status, RolloutStatus::kOk);
  Recording recording;
  EXPECT_EQ(Rollout(solver, soft_, model->RestState(), options, &recording).status,
            RolloutStatus::kBlocked);
  EXPECT_EQ(RolloutTangent(solver, soft_, soft_, model->RestState(), options).rollout.status,
            RolloutStatus::kBlocked);
}

// Cloth on triangle meshes in linearly implicit steps and at rest: closed forms and derivatives.

Obstacle AsObstacle(test::ClosedMesh mesh, const Eigen::Vector3d& move) {
  mesh.x.colwise() += move;
  return std::make_shared<const SurfaceObstacle>(mesh.x, mesh.triangles, Eigen::Matrix3Xd(), 0.03,
                                                 SurfaceBlend::kPlaces);
}

// Held in the middle, at z = 0, on what is below it.
Scene HeldOver(const Obstacle& obstacle, double held, double thickness = 4e-4) {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  scene.handles = Handles{.regions = {DiscRegion{.radius = held}}, .stiffness = 1e3};
  scene.contact = Contact{.thickness = thickness, .obstacles = {obstacle}};
  return scene;
}

class MeshDrapesTest : public testing::Test {
 protected:
  static std::unique_ptr<Backend> Make(const Scene& scene, int vertices = 400) {
    return MakeCpuBackend(std::make_shared<ClothModel>(MakeDisc({.target_vertices = vertices}),
                                                       scene, MakeLaw("smooth")),
                          1);
  }
  EquilibriumResult Settle(Backend& backend, const MaterialField& material,
                           const Eigen::VectorXd& x, double tolerance = 1e-9) const {
    const State start{x, Eigen::VectorXd::Zero(x.size())};
    const RolloutInput input{&material, &start};
    return backend.Equilibria({&input, 1}, {.tolerance = tolerance})[0];
  }
  // From the flat cloth.
  Eigen::VectorXd Relax(Backend& backend, int steps = 100) const {
    const State flat = backend.model().RestState();
    const RolloutInput input{&material_, &flat};
    const RolloutResult relaxed =
        backend.Rollouts({&input, 1}, {.h = 0.05, .steps = steps}, nullptr)[0];
    EXPECT_EQ(relaxed.status, RolloutStatus::kOk);
    return relaxed.end.x;
  }
  static double LargestMove(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a - b).reshaped(3, a.size() / 3).colwise().norm().maxCoeff();
  }
  // The material with entry k of its 39 times a factor.
  MaterialField Changed(int k, double factor) const {
    MaterialField changed = material_;
    (k < kStretchEntries ? changed.stretch[0].entries()[k]
                         : changed.bend[0].entries()[k - kStretchEntries]) *= factor;
    return changed;
  }
  // Largest error of the columns, of each relative to itself or a thousandth of the longest.
  template <class EndOf>
  double ErrorOfColumns(const RowMatrix& tangent, double step, const EndOf& end) const {
    const double longest = tangent.colwise().norm().maxCoeff();
    double error = 0.0;
    for (int k = 0; k < kMaterialEntries; ++k) {
      const Eigen::VectorXd difference =
          (end(Changed(k, 1 + step)) - end(Changed(k, 1 - step))) / (2 * step);
      const Eigen::VectorXd column = tangent.col(k);
      error =
          std::max(error, (difference - column).norm() / std::max(column.norm(), 1e-3 * longest));
    }
    return error;
  }

  MaterialField material_ = LinearMaterial(500.0, 2e-6, 0.3);
};

// Flat facets push as a plane does, over the edges between them too.
TEST_F(MeshDrapesTest, ATableOfFacetsIsAPlane) {
  const auto on_plane = Make(HeldOver(PlaneObstacle{.offset = -7e-4}, 0.02));
  const auto on_table =
      Make(HeldOver(AsObstacle(test::MakeCube(0.5), {-0.25, -0.25, -0.5 - 7e-4}), 0.02));
  const Eigen::VectorXd plane = Relax(*on_plane, 20), table = Relax(*on_table, 20);
  EXPECT_LT(LargestMove(plane, table), 1e-12);
  EXPECT_LT(SmallestGap(*on_table->model().scene.contact, table), 5e-4);
  const EquilibriumResult rest_on_plane = Settle(*on_plane, material_, plane),
                          rest_on_table = Settle(*on_table, material_, table);
  ASSERT_EQ(rest_on_plane.status, EquilibriumStatus::kStable);
  ASSERT_EQ(rest_on_table.status, EquilibriumStatus::kStable);
  EXPECT_LT(LargestMove(rest_on_plane.x, rest_on_table.x), 1e-9);
}

// The same drape over a ball and over meshes of it, with the square of their edges.
TEST_F(MeshDrapesTest, DrapesOverFinerBallsConvergeToThatOverTheBall) {
  constexpr double kRadius = 0.1;
  const Eigen::Vector3d centre(0.0, 0.0, -kRadius - 8e-4);
  const auto ball = Make(HeldOver(SphereObstacle{.centre = centre, .radius = kRadius}, 0.02));
  const EquilibriumResult rest = Settle(*ball, material_, Relax(*ball));
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable);
  double before = 0.0;
  for (int divisions = 3; divisions <= 6; ++divisions) {
    const auto mesh = Make(HeldOver(AsObstacle(test::MakeBall(kRadius, divisions), centre), 0.02));
    const EquilibriumResult there = Settle(*mesh, material_, rest.x);
    EXPECT_EQ(there.status, EquilibriumStatus::kStable) << divisions;
    const double move = LargestMove(there.x, rest.x);
    if (before > 0.0) {
      EXPECT_LT(move, 0.5 * before) << divisions;
    }
    before = move;
  }
  EXPECT_LT(before, 1e-4);
}

// A strip that slides into the concave edge of a stair with one end.
class StairTest : public MeshDrapesTest {
 protected:
  static constexpr double kTread = 0.2;
  StairTest() {
    Scene scene;
    scene.gravity = Eigen::Vector3d(-5.0, 0.0, -9.8);
    scene.contact = Contact{.obstacles = {AsObstacle(test::MakeStair(kTread, 0.4), move_)}};
    backend_ = MakeCpuBackend(
        std::make_shared<ClothModel>(MakeStrip(0.1, 0.1, 12, 14), scene, MakeLaw("smooth")), 1);
    start_ = backend_->model().RestState();
    std::mt19937_64 random(3);
    for (Eigen::Index i = 0; i < start_.x.size(); ++i) start_.x[i] += 5e-5 * SampleNormal(random);
    input_ = {&material_, &start_};
  }
  const Contact& contact() const { return *backend_->model().scene.contact; }

  // The end is .78 mm from the riser, the strip .66 mm over the tread.
  Eigen::Vector3d move_{-7.8e-4 - kTread, -0.2, -6.6e-4 - kTread};
  std::unique_ptr<Backend> backend_;
  State start_;
  RolloutInput input_;
  RolloutOptions options_{.h = 2e-3, .steps = 8};
};

TEST_F(StairTest, RolloutDerivativesAreDifferences) {
  const std::vector<const MaterialField*> weights = {&material_};
  const TangentResult tangent = backend_->Tangents({&input_, 1}, weights, options_)[0];
  ASSERT_EQ(tangent.rollout.status, RolloutStatus::kOk);
  int pushed = 0, blended = 0;
  for (Eigen::Index i = 0; i < start_.x.size(); i += 3) {
    const ObstacleDistance at =
        DistanceTo(contact().obstacles[0], tangent.rollout.end.x.segment<3>(i));
    pushed += at.value - contact().offset() < contact().range;
    blended += at.value - contact().offset() < contact().range && at.curvature.trace() < -100.0;
  }
  EXPECT_GT(pushed, 100);
  EXPECT_GT(blended, 0);
  const double error = ErrorOfColumns(tangent.dx, 3e-4, [&](const MaterialField& material) {
    const RolloutInput input{&material, &start_};
    return backend_->Rollouts({&input, 1}, options_, nullptr)[0].end.x;
  });
  EXPECT_LT(error, 1e-6);
  std::vector<Recording> recordings;
  ASSERT_EQ(backend_->Rollouts({&input_, 1}, options_, &recordings)[0].status, RolloutStatus::kOk);
  const RowMatrix u = RowMatrix::Random(start_.x.size(), 2);
  const AdjointResult adjoint =
      backend_->Adjoints({&input_, 1}, recordings, std::vector<RowMatrix>{u}, options_)[0];
  ASSERT_EQ(adjoint.status, RolloutStatus::kOk);
  const RowMatrix by_tangent = tangent.dx.transpose() * u,
                  by_adjoint = adjoint.material.Contract(material_);
  EXPECT_LT((by_adjoint - by_tangent).norm(), 1e-10 * by_tangent.norm());
}

// At rest over edges and corners, whose distance is curved, and over a stair; the cloth is thick,
// so that more of its vertices are over them.
TEST_F(MeshDrapesTest, DerivativesOfEquilibriaAreDifferences) {
  material_ = LinearMaterial(500.0, 3e-6, 0.3);
  for (const Obstacle& obstacle :
       {AsObstacle(test::MakeBall(0.1, 0), {0.0, 0.0, -0.1 - 2.6e-3}),
        AsObstacle(test::MakeBall(0.06, 2), {0.0, 0.0, -0.06 - 2.6e-3}),
        AsObstacle(test::MakeStair(0.03, 0.1), {-0.01, -0.05, -0.06 - 2.6e-3})}) {
    const auto backend = Make(HeldOver(obstacle, 0.02, 4e-3));
    const Contact& contact = *backend->model().scene.contact;
    const EquilibriumResult rest = Settle(*backend, material_, Relax(*backend), 5e-12);
    ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
    int curved = 0;
    for (Eigen::Index i = 0; i < rest.x.size(); i += 3) {
      const ObstacleDistance at = DistanceTo(obstacle, rest.x.segment<3>(i));
      curved +=
          at.value - contact.offset() < contact.range && std::abs(at.curvature.trace()) > 100.0;
    }
    const State at{rest.x, Eigen::VectorXd::Zero(rest.x.size())};
    const RolloutInput input{&material_, &at};
    const std::vector<const MaterialField*> weights = {&material_};
    const RowMatrix tangent = backend->EquilibriumTangents({&input, 1}, weights)[0];
    ASSERT_EQ(tangent.cols(), kMaterialEntries);
    const double error = ErrorOfColumns(tangent, 3e-5, [&](const MaterialField& material) {
      return Settle(*backend, material, rest.x, 5e-12).x;
    });
    EXPECT_GT(curved, 1);
    EXPECT_LT(error, 1e-6);
    const RowMatrix u = RowMatrix::Random(rest.x.size(), 2);
    const auto gradient = backend->EquilibriumAdjoints({&input, 1}, std::vector<RowMatrix>{u})[0];
    ASSERT_TRUE(gradient);
    const RowMatrix by_tangent = tangent.transpose() * u;
    EXPECT_LT((gradient->Contract(material_) - by_tangent).norm(), 1e-9 * by_tangent.norm());
  }
}

TEST_F(MeshDrapesTest, AMeshThatNothingTouchesChangesNoBit) {
  Scene without = CusickScene(), with = CusickScene();
  with.contact = Contact{.obstacles = {AsObstacle(test::MakeStair(0.1, 0.2), {0.3, 0.0, -0.1})}};
  const auto free = Make(without), beside = Make(with);
  const RolloutOptions options{.h = 0.05, .steps = 10};
  const State start = free->model().RestState();
  const RolloutInput input{&material_, &start};
  const std::vector<const MaterialField*> weights = {&material_};
  const TangentResult a = free->Tangents({&input, 1}, weights, options)[0],
                      b = beside->Tangents({&input, 1}, weights, options)[0];
  EXPECT_EQ(a.rollout.end.x, b.rollout.end.x);
  EXPECT_EQ(a.dx, b.dx);
}

// What contact without friction conserves, and what may only fall.

constexpr double kFreeStep = 5e-3;

// A sheet of 14 g that flies at an obstacle, without gravity.
class Collision {
 public:
  explicit Collision(const Obstacle& obstacle) {
    Scene scene;
    scene.contact = Contact{.obstacles = {obstacle}};
    model_ =
        std::make_shared<ClothModel>(MakeDisc({.target_vertices = 150}), scene, MakeLaw("smooth"));
    mass_ = model_->LumpedMass(material_.density);
    euler_ = std::make_unique<ImplicitEuler>(model_, material_, kFreeStep,
                                             ImplicitEulerOptions{.tolerance = 1e-11});
    now_ = model_->RestState();
    std::mt19937_64 random(7);
    for (Eigen::Index i = 0; i < now_.x.size(); i += 3) {
      now_.v.segment<3>(i) << 0.3, -0.2, -1.0;
      now_.v[i + 2] += 0.05 * SampleNormal(random);
    }
    before_ = now_;
  }

  bool Advance() {
    before_ = now_;
    return euler_->Advance(now_) == IntegratorStatus::kOk;
  }

  bool touches() const {
    return SmallestGap(*model_->scene.contact, now_.x) < model_->scene.contact->range;
  }
  double kinetic() const { return 0.5 * now_.v.dot(mass_.cwiseProduct(now_.v)); }
  double energy() const { return kinetic() + Energy(*model_, material_, now_.x); }
  // Σ m·Δv of the last step [kg m/s].
  Eigen::Vector3d Impulse() const { return Changes().rowwise().sum(); }
  // Σ (x − centre) × m·Δv, with x after the step, where its forces act [kg m²/s].
  Eigen::Vector3d AngularImpulse(const Eigen::Vector3d& centre) const {
    const Eigen::Matrix3Xd changes = Changes();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < changes.cols(); ++i)
      sum += (now_.x.segment<3>(3 * i) - centre).cross(changes.col(i));
    return sum;
  }

 private:
  Eigen::Matrix3Xd Changes() const {
    return mass_.cwiseProduct(now_.v - before_.v).reshaped(3, now_.v.size() / 3);
  }

  MaterialField material_ = LinearMaterial(200.0, 1e-5, 0.2);
  std::shared_ptr<const ClothModel> model_;
  Eigen::VectorXd mass_;
  std::unique_ptr<ImplicitEuler> euler_;
  State now_, before_;
};

TEST(Collision, APlaneTakesNoMomentumAlongIt) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, 0.1, 1.0).normalized();
  Collision sheet(PlaneObstacle{.normal = normal, .offset = -0.06});
  double largest = 0.0;
  for (int step = 0; step < 60; ++step) {
    ASSERT_TRUE(sheet.Advance()) << step;
    const Eigen::Vector3d impulse = sheet.Impulse();
    const double along_normal = impulse.dot(normal);
    EXPECT_GT(along_normal, -1e-12) << step;
    EXPECT_LT((impulse - along_normal * normal).norm(), 1e-12) << step;
    largest = std::max(largest, along_normal);
  }
  EXPECT_GT(largest, 1e-3);
}

TEST(Collision, ASphereTakesNoAngularMomentumAboutItsCentre) {
  const SphereObstacle sphere{.centre = {0.03, 0.01, -0.12}, .radius = 0.1};
  Collision sheet(sphere);
  double largest = 0.0;
  for (int step = 0; step < 60; ++step) {
    ASSERT_TRUE(sheet.Advance()) << step;
    EXPECT_LT(sheet.AngularImpulse(sphere.centre).norm(), 1e-12) << step;
    largest = std::max(largest, sheet.Impulse().norm());
  }
  EXPECT_GT(largest, 1e-4);
}

// Of kinetic, elastic and contact energy; the first alone, which is all there is at the start, is
// then never more than it was.
TEST(Collision, EnergyDoesNotGrow) {
  for (const Obstacle& obstacle :
       {Obstacle(PlaneObstacle{.offset = -0.03}),
        Obstacle(SphereObstacle{.centre = {0.03, 0.01, -0.12}, .radius = 0.1}),
        Obstacle(CapsuleObstacle{
            .from = {-0.05, 0.0, -0.08}, .to = {0.05, 0.02, -0.07}, .radius = 0.03}),
        Obstacle(PlateObstacle{.top = {0.05, 0.0, -0.03}, .radius = 0.1})}) {
    Collision sheet(obstacle);
    const double first = sheet.energy();
    ASSERT_EQ(first, sheet.kinetic());
    double before = first;
    bool touched = false;
    for (int step = 0; step < 60; ++step) {
      ASSERT_TRUE(sheet.Advance()) << obstacle.index() << " " << step;
      EXPECT_LT(sheet.energy(), before + 1e-9 * first) << obstacle.index() << " " << step;
      EXPECT_LT(sheet.kinetic(), first) << obstacle.index() << " " << step;
      before = sheet.energy();
      touched |= sheet.touches();
    }
    EXPECT_TRUE(touched) << obstacle.index();
    EXPECT_LT(before, 0.9 * first) << obstacle.index();
  }
}

// Accepted shapes of Newton's method have less and less energy, but near the end, where rounding
// decides.
TEST(ContactStatics, EnergyFalls) {
  Scene scene = CusickScene();
  scene.contact = Contact{.obstacles = {SphereObstacle{.centre = {0.1, 0.0, -0.06}, .radius = 0.04},
                                        PlaneObstacle{.offset = -0.04}}};
  StepSolver solver(
      std::make_shared<ClothModel>(MakeDisc({.target_vertices = 300}), scene, MakeLaw("smooth")));
  const MaterialField material = LinearMaterial(200.0, 5e-6, 0.2);
  const EquilibriumResult rest = SolveEquilibrium(solver, material, solver.model().mesh.rest_x, {});
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  EXPECT_LT(SmallestGap(*scene.contact, rest.x), scene.contact->range);
  double energy = rest.start_energy;
  for (const NewtonStep& step : rest.steps) {
    if (!step.accepted || step.residual < 1e-6) continue;
    EXPECT_LT(step.energy, energy);
    energy = step.energy;
  }
  EXPECT_LT(energy, rest.start_energy);
  // And no way leads further down.
  std::mt19937_64 random(8);
  const auto rises = [&](const Eigen::VectorXd& move) {
    return Energy(solver.model(), material, rest.x + move) >
           Energy(solver.model(), material, rest.x);
  };
  for (int i = 0; i < 20; ++i) {
    Eigen::VectorXd move(rest.x.size());
    for (double& part : move) part = 1e-6 * SampleNormal(random);
    EXPECT_TRUE(rises(move) && rises(-move)) << i;
  }
}

}  // namespace
}  // namespace drape
