// SPDX-License-Identifier: Apache-2.0
// Equilibria: Newton's method, the changes that must not affect it, and the implicit derivatives.
#include "physics/simulation/statics/statics.h"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdio>
#include <limits>

#include "physics/cloth/assembly/assembly.h"
#include "physics/cloth/state.h"
#include "physics/mesh/mesh_spec.h"
#include "physics/simulation/backend.h"
#include "physics/simulation/rollout.h"
#include "physics/simulation/statics/stiffness.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

using testing::DoubleEq;
using testing::Optional;

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

// The decisions of Newton's method on artificial residuals and energies.

constexpr double kFirstRadius = 3e-3;
const EquilibriumOptions kOptions{
    .tolerance = 1e-9, .shift = {.first = 25.0, .most = 400.0}, .first_radius = kFirstRadius};

class NewtonControlTest : public testing::Test {
 protected:
  // A step whose first factorisation succeeds.
  NewtonVerdict Step(double move, double residual, double energy) {
    EXPECT_EQ(control_.Next(), NewtonNext::kStep);
    control_.FirstShift();
    control_.Scale(move);
    return control_.Judge(residual, energy);
  }
  // The largest move that the next step may make [m].
  double Radius() {
    constexpr double kFar = 1e3;
    return kFar * control_.Scale(kFar);
  }
  NewtonControl control_{kOptions, 1.0, 0.0};
};

TEST_F(NewtonControlTest, EndsAtTheToleranceOnly) {
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);
  EXPECT_EQ(Step(1e-4, 1.1e-9, -1.0), NewtonVerdict::kAccept);
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);
  EXPECT_EQ(Step(1e-4, 1e-9, -2.0), NewtonVerdict::kAccept);
  EXPECT_EQ(control_.Next(), NewtonNext::kConverged);
  EXPECT_EQ(NewtonControl(kOptions, std::numeric_limits<double>::quiet_NaN(), 0.0).Next(),
            NewtonNext::kStep);
}

TEST_F(NewtonControlTest, EndsWhereOnlyRoundingIsLeft) {
  for (const double residual : {5e-8, 4e-8, 3e-8, 2e-8, 1.7e-8}) Step(1e-4, residual, -1.0);
  for (int step = 0; step < 3; ++step) Step(1e-4, 1.7e-8, -1.0);
  Step(1e-4, 2e-7, -1.0);
  for (int step = 0; step < 4; ++step) Step(1e-4, 1.8e-8, -1.0);
  EXPECT_EQ(control_.Next(), NewtonNext::kConverged);
}

TEST_F(NewtonControlTest, EndsAtTheIterationLimitAndWhenCancelled) {
  std::atomic<bool> cancel = false;
  EquilibriumOptions options = kOptions;
  options.max_iterations = 2;
  options.cancel = &cancel;
  control_ = NewtonControl(options, 1.0, 0.0);
  Step(1e-4, 0.9, -1.0);
  Step(1e-4, 0.8, -2.0);
  EXPECT_EQ(control_.Next(), NewtonNext::kGiveUp);
  EXPECT_EQ(control_.iterations(), 2);
  cancel = true;
  EXPECT_EQ(control_.Next(), NewtonNext::kCancelled);
}

TEST_F(NewtonControlTest, AFailedFactorisationRaisesTheShiftUntilNoneIsLeft) {
  EXPECT_EQ(control_.FirstShift(), 0.0);
  EXPECT_THAT(control_.NextShift(), Optional(25.0));
  EXPECT_THAT(control_.NextShift(), Optional(100.0));
  EXPECT_THAT(control_.NextShift(), Optional(400.0));
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);
  EXPECT_EQ(control_.NextShift(), std::nullopt);
  EXPECT_EQ(control_.Next(), NewtonNext::kGiveUp);
  EXPECT_EQ(control_.factorisations(), 4);
}

TEST_F(NewtonControlTest, TheShiftStaysWhereItWasRaisedAndDecaysAfterwards) {
  control_.FirstShift();
  control_.NextShift();
  control_.NextShift();
  control_.Scale(1e-4);
  control_.Judge(0.9, -1.0);
  for (const double expected : {100.0, 25.0, 6.25, 0.0, 0.0}) {
    EXPECT_EQ(control_.FirstShift(), expected);
    control_.Scale(1e-4);
    control_.Judge(0.9, -1.0);
  }
  EXPECT_EQ(control_.steps()[0].shift, 100.0);
  EXPECT_EQ(control_.steps()[2].shift, 25.0);
}

TEST_F(NewtonControlTest, AShortenedStepKeepsAShift) {
  Step(2 * kFirstRadius, 0.9, -1.0);
  EXPECT_EQ(control_.FirstShift(), kOptions.shift.first);
}

TEST_F(NewtonControlTest, StepsAreShortenedToTheRadius) {
  EXPECT_EQ(control_.Scale(0.95 * kFirstRadius), 1.0);
  EXPECT_EQ(control_.Scale(kFirstRadius), 1.0);
  EXPECT_THAT(control_.Scale(4 * kFirstRadius), DoubleEq(0.25));
}

TEST_F(NewtonControlTest, TheRadiusGrowsAfterShortenedStepsUpToItsMaximum) {
  Step(0.5 * kFirstRadius, 0.9, -1.0);
  EXPECT_THAT(Radius(), DoubleEq(kFirstRadius));
  control_.Judge(0.8, -2.0);
  EXPECT_THAT(Radius(), DoubleEq(1.5 * kFirstRadius));
  control_.Judge(0.8, -3.0);
  Step(0.5 * kFirstRadius, 0.8, -4.0);
  EXPECT_THAT(Radius(), DoubleEq(1.5 * 1.5 * kFirstRadius));
  for (int i = 0; i < 10; ++i) Step(1.0, 0.8, -5.0 - i);
  EXPECT_THAT(Radius(), DoubleEq(kOptions.max_radius));
}

TEST_F(NewtonControlTest, ALongNonMonotoneRunThatEndsWellKeepsTheRadius) {
  EXPECT_EQ(Step(1.0, 0.9, 1.0), NewtonVerdict::kNonMonotone);
  EXPECT_EQ(Step(1.0, 0.9, 1.0), NewtonVerdict::kNonMonotone);
  EXPECT_EQ(Step(1.0, 0.9, -1.0), NewtonVerdict::kAccept);
  EXPECT_THAT(Radius(), DoubleEq(kFirstRadius));
  control_.Judge(0.9, 0.0);  // one step above the best energy, then one below
  EXPECT_EQ(Step(1e-4, 0.9, -2.0), NewtonVerdict::kAccept);
  EXPECT_THAT(Radius(), DoubleEq(1.5 * kFirstRadius));
}

TEST_F(NewtonControlTest, TheNinthStepAboveTheBestEnergyIsRejected) {
  Step(1e-4, 0.5, -1.0);
  for (int i = 0; i < 8; ++i)
    ASSERT_EQ(Step(1e-4, 0.1, -1.0 + 0.01 * i), NewtonVerdict::kNonMonotone) << i;
  EXPECT_EQ(Step(0.5 * kFirstRadius, 1e-10, 0.0), NewtonVerdict::kRejectStep);
  EXPECT_EQ(control_.Next(), NewtonNext::kStep);  // the best shape is not an equilibrium
  EXPECT_THAT(Radius(), DoubleEq(0.35 * 0.5 * kFirstRadius));
  control_.Judge(0.4, -2.0);
  EXPECT_EQ(control_.steps().back().residual, 0.5);
  EXPECT_EQ(Step(1e-4, 0.5, 0.0), NewtonVerdict::kNonMonotone);  // the count restarts
}

TEST_F(NewtonControlTest, AnEnergyThatIsNotFiniteIsRejectedAtOnce) {
  for (const double energy :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(Step(1e-4, 0.5, energy), NewtonVerdict::kRejectStep) << energy;
}

TEST_F(NewtonControlTest, GivesUpWhenStepsHaveNoLength) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Step(1e-8, 0.5, nan);
  EXPECT_EQ(Step(1e-9, 0.5, nan), NewtonVerdict::kRejectStep);
  EXPECT_EQ(control_.Next(), NewtonNext::kGiveUp);
}

TEST_F(NewtonControlTest, NearTheEndALowerResidualIsEnough) {
  EXPECT_EQ(Step(1e-4, 1e-4, 1.0), NewtonVerdict::kNonMonotone);  // the best one has energy 1
  EXPECT_EQ(Step(1e-4, 5e-4, -1.0), NewtonVerdict::kAccept);
  EXPECT_EQ(Step(1e-4, 4.6e-4, -0.5), NewtonVerdict::kNonMonotone);
  EXPECT_EQ(Step(1e-4, 4.4e-4, -0.5), NewtonVerdict::kAccept);
  EXPECT_EQ(Step(1e-4, 4.4e-4, -0.6), NewtonVerdict::kAccept);  // below the last accepted energy
  ASSERT_EQ(control_.steps().size(), 5u);
  EXPECT_FALSE(control_.steps()[2].accepted);
  EXPECT_TRUE(control_.steps()[3].accepted);
  EXPECT_EQ(control_.steps()[3].residual, 4.6e-4);
  EXPECT_EQ(control_.steps()[3].energy, -0.5);
}

TEST_F(NewtonControlTest, ADrapeIsStableWhileTheSkewPartOfKIsSmall) {
  EXPECT_EQ(control_.Conclude(0.99), EquilibriumStatus::kStable);
  EXPECT_EQ(control_.Conclude(1.0), EquilibriumStatus::kUnstable);
  EXPECT_EQ(control_.Conclude(std::nullopt), EquilibriumStatus::kUnstable);
  EXPECT_EQ(control_.factorisations(), 3);
}

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
