// SPDX-License-Identifier: Apache-2.0
// What contact without friction conserves, and what may only fall.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>

#include "physics/cloth/assembly/assembly.h"
#include "physics/mesh/disc.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/statics/statics.h"
#include "physics/simulation/textbook.h"
#include "physics/util/math/random.h"

namespace drape {
namespace {

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
