// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <cstdio>

#include "physics/cloth/assembly/assembly.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/rollout.h"
#include "physics/simulation/statics/statics.h"
#include "physics/simulation/statics/stiffness.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// All eigenvalues, by dense algebra.
Eigen::VectorXd DenseEigenvalues(const ClothModel& model, const MaterialField& material,
                                 const Eigen::VectorXd& x) {
  const int n = model.num_dofs();
  BlockMatrix negative(model.pattern);
  AssembleStepDerivative(model, material, x, Eigen::VectorXd::Zero(n), 1.0, negative);
  RowMatrix K = RowMatrix::Zero(n, n);
  AddMultiply(model.pattern, negative, RowMatrix::Identity(n, n), K);
  const Eigen::MatrixXd symmetric = -0.5 * (K + K.transpose());
  const Eigen::MatrixXd mass = model.LumpedMass(material.density).asDiagonal();
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, mass,
                                                                   Eigen::EigenvaluesOnly)
      .eigenvalues();
}

// At a drape and at a shape that is not an equilibrium, whose lowest eigenvalues are negative.
TEST(LowestEigenvalues, AgreeWithDenseAlgebra) {
  constexpr int kCount = 6;
  for (const char* law : {"reference", "smooth"}) {
    StepSolver solver(test::SmallDisc(law));
    const MaterialField material = test::TestMaterial();
    std::mt19937_64 random(4);
    const State start = test::NoisyStart(solver.model(), 2e-3, random);
    const State relaxed = Rollout(solver, material, start, {.h = 0.1, .steps = 20}).end;
    const EquilibriumResult rest = SolveEquilibrium(solver, material, relaxed.x, {});
    ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
    for (const bool at_rest : {true, false}) {
      const Eigen::VectorXd& x = at_rest ? rest.x : start.x;
      const Eigen::VectorXd dense = DenseEigenvalues(solver.model(), material, x).head(kCount);
      const Eigen::VectorXd found = LowestEigenvalues(solver, material, x, kCount);
      ASSERT_EQ(found.size(), kCount);
      std::printf("%s: lowest %.6g, dense %.6g\n", law, found[0], dense[0]);
      EXPECT_LT((found - dense).norm(), 1e-8 * dense.norm());
      EXPECT_EQ(found[0] > 0.0, at_rest);
    }
  }
}

// The first bending mode of a narrow cantilever without gravity: ω² = 1.8751⁴·D(1 − ν²)/(ρL⁴), ν =
// −1/3 of the hinge formula. The tolerance of 3 % covers the hinges that free edges lack and the
// uneven end of the clamp.
TEST(LowestEigenvalues, FirstBendingOfACantilever) {
  const double density = 0.2, spacing = 0.1 / 40, clamp = 3.1 * spacing, rigidity = 1e-5;
  Scene scene;
  scene.handles = Handles{.stiffness = 1e6};
  ClothModel model(MakeStrip(44 * spacing, 10 * spacing * std::sqrt(0.75), 44, 10), scene,
                   MakeLaw("smooth"));
  model.held.clear();
  for (int i = 0; i < model.mesh.num_vertices(); ++i)
    if (model.mesh.uv(0, i) <= clamp) model.held.push_back(i);
  MaterialField material = test::TestMaterial();
  material.density = density;
  for (double& entry : std::span(&material.bend[0].b[0][0], kBendEntries))
    entry = kBendPerRigidity * rigidity;
  StepSolver solver(std::make_shared<ClothModel>(std::move(model)));
  const Eigen::VectorXd found = LowestEigenvalues(solver, material, solver.model().mesh.rest_x, 2);
  ASSERT_EQ(found.size(), 2);
  const double length = (44 - 3 + 0.25) * spacing;
  const double expected = std::pow(1.8751041 / length, 4) * rigidity * (1.0 - 1.0 / 9.0) / density;
  std::printf("omega^2 %.4f, beam %.4f\n", found[0], expected);
  EXPECT_NEAR(found[0], expected, 0.03 * expected);
}

}  // namespace
}  // namespace drape
