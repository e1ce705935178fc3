// SPDX-License-Identifier: Apache-2.0
// Equilibria: Newton's method, the changes that must not affect it, and the implicit derivatives.
#include "physics/simulation/statics/statics.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdio>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/state.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

// A table with equal rows, for which the stretch law is the gradient of StretchEnergy.
MaterialField ConstantMaterial() {
  MaterialField material = test::TestMaterial();
  for (auto& row : material.stretch[0].c) std::copy_n(material.stretch[0].c[0], kStretchCols, row);
  for (auto& row : material.bend[0].b) std::fill(row, row + kBendCols, 6e-5);
  return material;
}

// Twenty dynamic steps from a random start, after which Newton's method may begin.
State RelaxedStart(StepSolver& solver, const MaterialField& material) {
  State start = solver.model().RestState();
  start.x = ApplyStartShape(solver.model().mesh, 0.09, RandomStartShape(3, 5e-3));
  const RolloutResult relaxed = Rollout(solver, material, start, {.h = 0.1, .steps = 20});
  EXPECT_EQ(relaxed.status, RolloutStatus::kOk);
  return relaxed.end;
}

class StaticsTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Laws, StaticsTest, testing::Values("reference", "smooth"),
                         [](const auto& info) { return info.param; });

TEST_P(StaticsTest, EnergyFallsMonotonicallyWithConstantTables) {
  StepSolver solver(test::SmallDisc(GetParam(), 300));
  const MaterialField material = ConstantMaterial();
  const EquilibriumResult rest =
      SolveEquilibrium(solver, material, RelaxedStart(solver, material).x, {.tolerance = 1e-10});
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  ASSERT_EQ(static_cast<int>(rest.steps.size()), rest.iterations);
  EXPECT_GE(rest.iterations, 4);
  double before = rest.start_energy;
  for (const NewtonStep& step : rest.steps) {
    if (!step.accepted) continue;
    // The tolerance covers the rounding of the sum over all elements, where the energy no longer
    // resolves a step.
    EXPECT_LE(step.energy, before + 1e-14 * std::fabs(before)) << "at residual " << step.residual;
    before = step.energy;
  }
  EXPECT_LT(before, rest.start_energy - 1e-6 * std::fabs(rest.start_energy));
}

// A cloth that is pushed out of its plane and released without gravity becomes flat again.
TEST_P(StaticsTest, WithoutGravityFlatIsTheDrape) {
  for (const bool listed : {false, true}) {
    Scene scene = CusickScene();
    scene.gravity.reset();
    if (listed) scene.gravity = Eigen::Vector3d::Zero();
    const auto model = std::make_shared<ClothModel>(MakeDisc({.target_vertices = 200}), scene,
                                                    MakeLaw(GetParam()));
    StepSolver solver(model);
    const MaterialField material = test::TestMaterial();
    const EquilibriumResult at_rest = SolveEquilibrium(solver, material, model->mesh.rest_x, {});
    EXPECT_EQ(at_rest.status, EquilibriumStatus::kStable);
    EXPECT_LT((at_rest.x - model->mesh.rest_x).cwiseAbs().maxCoeff(), 1e-12);
    const RolloutResult stepped =
        Rollout(solver, material, model->RestState(), {.h = 0.05, .steps = 100});
    EXPECT_LT((stepped.end.x - model->mesh.rest_x).cwiseAbs().maxCoeff(), 1e-12);
    std::mt19937_64 random(5);
    const EquilibriumResult back = SolveEquilibrium(
        solver, material, test::NoisyStart(*model, 1e-4, random).x, {.tolerance = 1e-13});
    EXPECT_EQ(back.status, EquilibriumStatus::kStable) << back.residual;
    EXPECT_LT((back.x - model->mesh.rest_x).cwiseAbs().maxCoeff(), 1e-12);
  }
}

// A strip stands upright on its clamped end. Greenhill (1881): the straight column is stable up to
// ρgL³/D = 7.837, with D(1 − ν²) of a narrow strip and ν = −1/3 of the hinge formula.
TEST_P(StaticsTest, StandingStripLosesStabilityAtGreenhillsLoad) {
  const double density = 0.2, gravity = 9.8, spacing = 0.1 / 40, clamp = 3.1 * spacing;
  Scene scene;
  scene.gravity = Eigen::Vector3d(-gravity, 0, 0);
  scene.handles = Handles{.stiffness = 1e6};
  ClothModel model(MakeStrip(44 * spacing, 10 * spacing * std::sqrt(0.75), 44, 10), scene,
                   MakeLaw(GetParam()));
  model.held.clear();
  for (int i = 0; i < model.mesh.num_vertices(); ++i)
    if (model.mesh.uv(0, i) <= clamp) model.held.push_back(i);
  StepSolver solver(std::make_shared<ClothModel>(std::move(model)));
  // The free length begins half a spacing earlier in every second row.
  const double length = (44 - 3 + 0.25) * spacing;
  const auto solve = [&](double gamma) {
    MaterialField material;
    material.density = density;
    material.stretch.resize(1);
    for (auto& row : material.stretch[0].c) row[0] = row[2] = 5e3, row[3] = 2.5e3;
    material.bend.resize(1);
    const double rigidity = density * gravity * std::pow(length, 3) / gamma / (1.0 - 1.0 / 9.0);
    for (double& entry : std::span(&material.bend[0].b[0][0], kBendEntries))
      entry = kBendPerRigidity * rigidity;
    return SolveEquilibrium(solver, material, solver.model().mesh.rest_x, {.max_iterations = 400});
  };
  const EquilibriumResult below = solve(0.95 * 7.837), above = solve(1.05 * 7.837);
  EXPECT_EQ(below.status, EquilibriumStatus::kStable) << below.residual << " " << below.iterations;
  EXPECT_EQ(above.status, EquilibriumStatus::kUnstable)
      << above.residual << " " << above.iterations;
  for (int i = 2; i < above.x.size(); i += 3) ASSERT_LT(std::fabs(above.x[i]), 1e-12);
}

// The relative difference between the forces on the same drape of `mesh` with `material` and those
// of the original.
double ForceChange(const Mesh& mesh, const MaterialField& material, const std::string& law,
                   const Eigen::VectorXd& x, const Eigen::VectorXd& expected) {
  Eigen::VectorXd force;
  AssembleForce(ClothModel(mesh, CusickScene(), MakeLaw(law)), material, x, force);
  return (force - expected).norm() / expected.norm();
}

// The same cloth is described from its other side, or with weft and warp along other axes of the
// mesh.
TEST_P(StaticsTest, OrientationAndAxesOfTheMeshDoNotMatter) {
  StepSolver solver(test::SmallDisc(GetParam(), 300));
  const Mesh& mesh = solver.model().mesh;
  const MaterialField material = test::TestMaterial();
  State drape = RelaxedStart(solver, material);
  std::mt19937_64 random(9);
  drape.x += 1e-3 * test::RandomMatrix(solver.model().num_dofs(), 1, random);
  Eigen::VectorXd force;
  AssembleForce(solver.model(), material, drape.x, force);

  auto reversed = ListTriangles(mesh);
  for (auto& triangle : reversed) std::swap(triangle[1], triangle[2]);
  Eigen::Matrix2Xd mirrored = mesh.uv;
  mirrored.row(0) *= -1.0;
  const Mesh mirrored_mesh = BuildMesh(mesh.rest_x, mirrored, reversed, "mirrored");
  const double turned_over = ForceChange(mirrored_mesh, material, GetParam(), drape.x, force);

  MaterialField swapped = material;
  for (int r = 0; r < kStretchRows; ++r) {
    const double* from = material.stretch[0].c[r == 0 ? 0 : kStretchRows - r];
    const double row[] = {from[2], from[1], from[0], from[3]};
    std::copy_n(row, kStretchCols, swapped.stretch[0].c[r]);
  }
  for (int r = 0; r < kBendRows; ++r)
    std::copy_n(material.bend[0].b[kBendRows - 1 - r], kBendCols, swapped.bend[0].b[r]);
  Eigen::Matrix2Xd rotated(2, mesh.num_vertices());
  rotated << -mesh.uv.row(1), mesh.uv.row(0);
  const Mesh rotated_mesh = BuildMesh(mesh.rest_x, rotated, ListTriangles(mesh), "rotated");
  const double rotated_both = ForceChange(rotated_mesh, swapped, GetParam(), drape.x, force);

  std::printf("%s: turned over %.1e, rotated by 90 degrees %.1e\n", GetParam().c_str(), turned_over,
              rotated_both);
  EXPECT_GT(ForceChange(rotated_mesh, material, GetParam(), drape.x, force), 1e-3);
  if (GetParam() == "smooth") {
    EXPECT_LT(turned_over, 1e-9);
    EXPECT_LT(rotated_both, 1e-9);
  } else {
    EXPECT_GT(turned_over, 1e-4);  // the sign of an angle selects its table column
  }
}

// Compares all 39 columns with central differences of equilibria that are solved again.
TEST_P(StaticsTest, TangentAgreesWithResolvedEquilibria) {
  StepSolver solver(test::SmallDisc(GetParam(), 200));
  const MaterialField material = test::TestMaterial();
  const EquilibriumOptions tight{.tolerance = 1e-12, .max_iterations = 8};
  const EquilibriumResult rest =
      SolveEquilibrium(solver, material, RelaxedStart(solver, material).x, {.tolerance = 1e-12});
  ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
  RowMatrix dx;
  ASSERT_TRUE(EquilibriumTangent(solver, material, material, rest.x, &dx));
  const auto solve = [&](int k, double step) {
    MaterialField moved = material;
    (k < kStretchEntries ? moved.stretch[0].entries()[k]
                         : moved.bend[0].entries()[k - kStretchEntries]) *= std::exp(step);
    // The start is the prediction of the tangent, so that both sides converge equally well.
    const EquilibriumResult result =
        SolveEquilibrium(solver, moved, rest.x + step * dx.col(k), tight);
    EXPECT_LT(result.residual, 1e-11) << "entry " << k << " step " << step;
    return result.x;
  };
  const double largest = dx.colwise().norm().maxCoeff();
  double worst = 0.0;
  int reached = 0;
  for (int k = 0; k < kMaterialEntries; ++k) {
    const double size = dx.col(k).norm();
    if (size < 1e-9 * largest) continue;  // curvatures that do not occur in this cloth
    ++reached;
    double best = 1.0;
    for (const double step : {1e-3, 1e-4, 1e-5}) {
      const Eigen::VectorXd difference = (solve(k, step) - solve(k, -step)) / (2 * step);
      best = std::min(best, (difference - dx.col(k)).norm() / size);
    }
    EXPECT_LT(best, 1e-6) << "entry " << k;
    worst = std::max(worst, best);
  }
  std::printf("%s: %d entries reached, worst %.1e\n", GetParam().c_str(), reached, worst);
  EXPECT_GE(reached, 24);
}

// One table for the cloth, and one for each face and hinge.
TEST_P(StaticsTest, AdjointAgreesWithTangentTo1em9) {
  const auto model = test::SmallDisc(GetParam(), 200);
  StepSolver solver(model);
  std::mt19937_64 random(21);
  for (const bool scattered : {false, true}) {
    MaterialField material = test::TestMaterial();
    if (scattered) material = test::Scatter(material, model->mesh, 0.3, random);
    const EquilibriumResult rest =
        SolveEquilibrium(solver, material, RelaxedStart(solver, material).x, {});
    ASSERT_EQ(rest.status, EquilibriumStatus::kStable) << rest.residual;
    const RowMatrix seeds = test::RandomMatrix(model->num_dofs(), 3, random);
    RowMatrix dx;
    ASSERT_TRUE(EquilibriumTangent(solver, material, material, rest.x, &dx));
    const RowMatrix by_tangent = dx.transpose() * seeds;
    const State state{rest.x, Eigen::VectorXd::Zero(rest.x.size())};
    const RolloutInput input{&material, &state};
    const auto gradients = MakeCpuBackend(model, 1)->EquilibriumAdjoints({&input, 1}, {&seeds, 1});
    ASSERT_TRUE(gradients[0]);
    const double error = (gradients[0]->Contract(material) - by_tangent).norm() / by_tangent.norm();
    std::printf("%s: adjoint against tangent %.1e\n", GetParam().c_str(), error);
    EXPECT_LT(error, 1e-9);
  }
}

}  // namespace
}  // namespace drape
