// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/scene_readouts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "physics/material/material_scaling.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "tests/losses/readout/differences.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/simulation/closed_forms.h"

namespace drape {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Eigen::VectorXd FindRest(const ClothModel& model, const MaterialField& material,
                         const EquilibriumOptions& options = {}) {
  StepSolver solver(std::make_shared<const ClothModel>(model));
  const EquilibriumResult rest = SolveFromRest(solver, material, options);
  EXPECT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  return rest.x;
}

std::vector<double> Frequencies(const ClothModel& model, const MaterialField& material,
                                const Eigen::VectorXd& x, std::vector<int> modes) {
  Eigen::VectorXd r;
  EXPECT_TRUE(
      FrequencyReadout(model, std::move(modes)).ReadCloth(material, x, &r, nullptr, nullptr));
  return {r.begin(), r.end()};
}

// A cantilever without gravity has f_k = β_k²/2π·√(EI/(ρL⁴)), β = 1.8751, 4.6941. Errors fall with
// the edges. The rows of the clamp end in turn at one edge and at a half, and beyond them the strip
// cannot curl, which makes it shorter by 0.058 of its width (METHODS).
TEST(FrequencyReadoutTest, ACantileverIsABeam) {
  constexpr double kLength = 0.1, kRigidity = 1e-5, kDensity = 0.2;
  const double kWidth = 0.2 * std::sqrt(0.75) * kLength;
  const MaterialField beam = LinearBeam(500.0, kRigidity, kDensity);
  double last[2] = {1.0, 1.0};
  for (const int n : {20, 40, 80}) {
    const double edge = kLength / n;
    Scene scene = CantileverScene(edge, 0.0);
    scene.handles->stiffness = 1e5;
    const ClothModel model(MakeStrip(kLength + edge, kWidth, n + 1, n / 5), scene,
                           MakeLaw("smooth"));
    const double free = kLength + 0.25 * edge - 0.058 * kWidth,
                 unit = std::sqrt(kRigidity / kDensity) / (2 * M_PI * free * free);
    const std::vector<double> found = Frequencies(model, beam, model.mesh.rest_x, {1, 2, 3});
    std::printf("%d edges: %.4f %.4f %.4f, beam %.4f %.4f\n", n, found[0] / unit, found[1] / unit,
                found[2] / unit, 3.5160, 22.0345);
    const double error[] = {std::abs(found[0] / (3.5160 * unit) - 1.0),
                            std::abs(found[1] / (22.0345 * unit) - 1.0)};
    for (int k = 0; k < 2; ++k) {
      EXPECT_LT(error[k], last[k]);
      last[k] = error[k];
    }
  }
  EXPECT_LT(last[0], 0.004);
  EXPECT_LT(last[1], 0.005);
}

// A strip that is pulled by a dead load is a string with one free end: f = (2k − 1)/4·√(F/(m·l)) by
// its mass m and its length l.
TEST(FrequencyReadoutTest, APulledStripIsAString) {
  constexpr double kPull = 2.0;
  const ClothModel model(MakeStrip(0.2, 0.01, 40, 2), UniaxialScene(0.2, kPull), MakeLaw("smooth"));
  const MaterialField cloth = LinearMaterial(1e4, 1e-9, 0.2);
  const Eigen::VectorXd x = FindRest(model, cloth, {.residual_regime = 1e9});
  const double length = x.reshaped(3, x.size() / 3).row(0).maxCoeff(),
               mass = 0.2 * model.vertex_area.sum();
  const std::vector<double> found = Frequencies(model, cloth, x, {1, 2, 3, 4, 5, 6});
  const double first = std::sqrt(kPull / (mass * length)) / 4;
  for (const double f : found) std::printf("%.4f ", f / first);
  std::printf("by that of the string, %.3f Hz\n", first);
  EXPECT_NEAR(found[0] / first, 1.0, 0.01);
}

// Tables that depend on strain and curvature, in a cloth that bends far down.
class FrequencyDerivative : public testing::Test {
 protected:
  const ClothModel model_ =
      ClothModel(MakeStrip(0.12, 0.05, 12, 5), CantileverScene(0.011, 9.8), MakeLaw("smooth"));
  const MaterialField material_ = test::TestMaterial();
  const FrequencyReadout readout_ = FrequencyReadout(model_, {1, 3});

  Eigen::VectorXd Read(const MaterialField& material, const Eigen::VectorXd& x) const {
    Eigen::VectorXd r;
    EXPECT_TRUE(readout_.ReadCloth(material, x, &r, nullptr, nullptr));
    return r;
  }
  // With the logarithms of the entries and the density changed along a direction.
  MaterialField Changed(double step) const {
    MaterialField changed = material_;
    for (int k = 0; k < kStretchEntries; ++k)
      changed.stretch[0].entries()[k] *= std::exp(step * direction_[k]);
    for (int k = 0; k < kBendEntries; ++k)
      changed.bend[0].entries()[k] *= std::exp(step * direction_[kStretchEntries + k]);
    changed.density *= std::exp(step * direction_[kMaterialEntries]);
    return changed;
  }
  // ∂/∂(step) of what numbers by log entries and by the density have as derivatives.
  Eigen::VectorXd Along(const RowMatrix& by_number) const {
    Eigen::VectorXd change = Eigen::VectorXd::Zero(kMaterialEntries + kDynamicsEntries);
    change.head(kMaterialEntries + 1) = direction_;
    change[kMaterialEntries + kByDensity] *= material_.density;
    return by_number * change;
  }

  const Eigen::VectorXd direction_ = RandomVector(kMaterialEntries + 1, 3);
  Eigen::VectorXd r_;
  ReadoutJacobian by_x_;
  MaterialJacobian by_material_;
};

TEST_F(FrequencyDerivative, AtHeldMaterialAndAtHeldShape) {
  constexpr double kStep = 1e-5;
  const Eigen::VectorXd x = FindRest(model_, material_);
  ASSERT_TRUE(readout_.ReadCloth(material_, x, &r_, &by_x_, &by_material_));
  EXPECT_FALSE(readout_.Read(x, &r_, nullptr));
  const Eigen::VectorXd move = 1e-3 * RandomVector(model_.num_dofs(), 8);
  const Eigen::VectorXd by_move =
      (Read(material_, x + kStep * move) - Read(material_, x - kStep * move)) / (2 * kStep);
  const Eigen::VectorXd by_tables =
      (Read(Changed(kStep), x) - Read(Changed(-kStep), x)) / (2 * kStep);
  for (int k = 0; k < 2; ++k) {
    std::printf("mode %d: by shape %.8g, differences %.8g; by tables %.8g, differences %.8g\n", k,
                (by_x_ * move)[k], by_move[k], Along(by_material_)[k], by_tables[k]);
    EXPECT_NEAR((by_x_ * move)[k], by_move[k], 2e-5 * by_x_.row(k).norm() * move.norm());
    EXPECT_NEAR(Along(by_material_)[k], by_tables[k], 1e-5 * std::abs(by_tables[k]));
  }
}

TEST_F(FrequencyDerivative, OfWholeEquilibria) {
  constexpr double kStep = 1e-3;
  StepSolver solver(std::make_shared<const ClothModel>(model_));
  const Eigen::VectorXd x = FindRest(model_, material_);
  RowMatrix dx;
  ASSERT_TRUE(EquilibriumTangent(solver, material_, material_, x, &dx, true));
  ASSERT_TRUE(readout_.ReadCloth(material_, x, &r_, &by_x_, &by_material_));
  const Eigen::VectorXd found = Along(by_x_ * dx + by_material_);
  const auto at = [&](double step) { return Read(Changed(step), FindRest(model_, Changed(step))); };
  const Eigen::VectorXd differences = (at(kStep) - at(-kStep)) / (2 * kStep);
  for (int k = 0; k < 2; ++k) {
    std::printf("mode %d: %.8g, differences %.8g\n", k, found[k], differences[k]);
    EXPECT_NEAR(found[k], differences[k], 2e-5 * std::abs(differences[k]));
  }
}

// A cloth that hangs from its handles weighs on them alone.
TEST(HandleForceReadoutTest, IsTheWeight) {
  const ClothModel model(MakeStrip(0.2, 0.1, 10, 5), CantileverScene(0.021, 9.8),
                         MakeLaw("smooth"));
  const MaterialField cloth = test::TestMaterial();
  const HandleForceReadout readout(model, model.held, Matrix3d::Identity());
  const Eigen::VectorXd x = FindRest(model, cloth);
  Eigen::VectorXd force;
  ASSERT_TRUE(readout.Read(x, &force, nullptr));
  EXPECT_EQ(readout.group(), 3);
  const double weight = 9.8 * 0.2 * model.vertex_area.sum();
  EXPECT_LT((force - weight * Vector3d::UnitZ()).norm(), 1e-8 * weight);
  test::ExpectDerivative(readout, x);
  // Two of the held vertices.
  const HandleForceReadout part(model, {model.held[0], model.held[3]}, Vector3d::UnitZ());
  ASSERT_TRUE(part.Read(x, &force, nullptr));
  ASSERT_EQ(force.size(), 1);
  const auto k = [&](int i) {
    return model.scene.handles->stiffness * (model.mesh.rest_x - x)[3 * model.held[i] + 2];
  };
  EXPECT_NEAR(force[0], k(0) + k(3), 1e-12);
}

// A strip that is pulled by F at the other end is held by −F, and F by width is the stress of its
// strain, k·E·λ by Green's strain E of the stretch λ.
TEST(HandleForceReadoutTest, IsThePullOfAStrip) {
  constexpr double kPull = 1.5, kWidth = 0.05, kStiffness = 400.0;
  const ClothModel model(MakeStrip(0.2, kWidth, 16, 4), UniaxialScene(0.2, kPull),
                         MakeLaw("smooth"));
  const Eigen::VectorXd x =
      FindRest(model, LinearMaterial(kStiffness, 1e-6, 0.2), {.residual_regime = 1e9});
  Eigen::VectorXd force;
  ASSERT_TRUE(HandleForceReadout(model, model.held, -Vector3d::UnitX()).Read(x, &force, nullptr));
  EXPECT_NEAR(force[0], kPull, 1e-8);
  const double end = x.reshaped(3, x.size() / 3).row(0).maxCoeff(), stretch = end / 0.2;
  std::printf("force %.8g, stress by stretch %.8g\n", force[0],
              kWidth * kStiffness * 0.5 * (stretch * stretch - 1.0) * stretch);
  EXPECT_NEAR(force[0], kWidth * kStiffness * 0.5 * (stretch * stretch - 1.0) * stretch,
              0.01 * kPull);
}

}  // namespace
}  // namespace drape
