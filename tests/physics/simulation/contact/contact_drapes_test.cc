// SPDX-License-Identifier: Apache-2.0
// Cloth that rests on obstacles: closed forms, derivatives, and scenes where nothing touches.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/contact/vertex_contact.h"
#include "physics/cloth/state.h"
#include "physics/mesh/disc.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/textbook.h"
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

}  // namespace
}  // namespace drape
