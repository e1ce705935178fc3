// SPDX-License-Identifier: Apache-2.0
// The integrators and Newton variants that the stability atlas compares.
#include "solver/studies/stability/stability_case.h"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <limits>

#include "physics/cloth/assembly/assembly.h"
#include "physics/simulation/rollout.h"
#include "physics/simulation/statics/stiffness.h"
#include "solver/studies/stability/stability_study.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/physics/file_fixture.h"

namespace drape {
namespace {

// ½(K + Kᵀ) by dense algebra, of a stiffness given as sign·K.
Eigen::MatrixXd Dense(const BlockPattern& pattern, const BlockMatrix& matrix, double sign) {
  const int n = 3 * pattern.num_vertices();
  RowMatrix K = RowMatrix::Zero(n, n);
  AddMultiply(pattern, matrix, RowMatrix::Identity(n, n), K);
  return 0.5 * sign * (K + K.transpose());
}

class IntegratorTest : public testing::Test {
 protected:
  Eigen::MatrixXd DenseStiffness(const Eigen::VectorXd& x) const {
    BlockMatrix negative(model_->pattern);
    AssembleStepDerivative(*model_, material_, x, Eigen::VectorXd::Zero(x.size()), 1.0, negative);
    return Dense(model_->pattern, negative, -1.0);
  }
  Eigen::MatrixXd DenseMass() const { return model_->LumpedMass(material_.density).asDiagonal(); }
  State Fallen(int steps) {
    StepSolver solver(model_);
    return Rollout(solver, material_, start_, {.h = 0.05, .steps = steps}).end;
  }

  std::mt19937_64 random_{3};
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth");
  MaterialField material_ = test::TestMaterial();
  State start_ = test::NoisyStart(*model_, 2e-3, random_);
};

// Held vertices without other forces swing at ω² = k/m each.
class OscillatorTest : public testing::Test {
 protected:
  OscillatorTest() {
    Scene scene;
    scene.stretch = scene.bend = false;
    scene.handles = Handles{.regions = {DiscRegion{.radius = 1.0}}, .stiffness = 0.5};
    model_ =
        std::make_shared<ClothModel>(MakeDisc({.target_vertices = 100}), scene, MakeLaw("smooth"));
    material_.density = 0.2;
  }
  // √(ω²a² + v²) of each coordinate after a step by that before it.
  Eigen::ArrayXd ComputeFactors(const Integrator& step, double h) const {
    State state = model_->RestState();
    state.x.array() += 1e-3;
    state.v.array() += 2e-3;
    const Eigen::ArrayXd before = Norm(state);
    EXPECT_EQ(step(state), IntegratorStatus::kOk) << h;
    return Norm(state) / before;
  }
  Eigen::ArrayXd OmegaSquared() const {
    return 0.5 * model_->LumpedMass(material_.density).array().inverse();
  }
  Eigen::ArrayXd Norm(const State& state) const {
    return (OmegaSquared() * (state.x - model_->mesh.rest_x).array().square() +
            state.v.array().square())
        .sqrt();
  }

  std::shared_ptr<const ClothModel> model_;
  MaterialField material_;
};

TEST_F(OscillatorTest, ImplicitStepsShrinkItAsTheoryOfImplicitEulerSays) {
  for (const double h : {1e-3, 0.05, 0.5}) {
    const Eigen::ArrayXd expected = (1.0 + h * h * OmegaSquared()).rsqrt();
    const auto newton = MakeImplicitEuler(model_, material_, h, {.tolerance = 1e-13});
    const auto direct = MakeLinearlyImplicitEuler(model_, material_, h, StepLinearSolver::kDirect);
    const auto pcg = MakeLinearlyImplicitEuler(model_, material_, h, StepLinearSolver::kPcg);
    for (const Integrator& step : {newton, direct, pcg})
      EXPECT_LT((ComputeFactors(step, h) / expected - 1.0).abs().maxCoeff(), 1e-6) << h;
  }
}

TEST_F(OscillatorTest, ExplicitStepsKeepItBelowTheLimitAndNotAbove) {
  const double limit = 2.0 / std::sqrt(OmegaSquared().maxCoeff());
  for (const double share : {0.5, 0.98, 1.02, 1.3}) {
    const auto step = MakeExplicitEuler(model_, material_, share * limit, 0.0);
    State state = model_->RestState();
    state.x.array() += 1e-3;
    for (int i = 0; i < 300; ++i) ASSERT_EQ(step(state), IntegratorStatus::kOk);
    EXPECT_EQ((state.x - model_->mesh.rest_x).cwiseAbs().maxCoeff() < 1.0, share < 1.0) << share;
  }
}

TEST_F(OscillatorTest, DragSlows) {
  const auto step = MakeExplicitEuler(model_, material_, 1e-6, 5.0);
  State state = model_->RestState();
  state.v.setConstant(1.0);
  ASSERT_EQ(step(state), IntegratorStatus::kOk);
  EXPECT_NEAR(state.v[0], 1.0 - 5e-6, 1e-9);
}

TEST_F(IntegratorTest, OneSolveStepIsThatOfRollout) {
  State direct = start_, pcg = start_, single = start_;
  const auto direct_step =
      MakeLinearlyImplicitEuler(model_, material_, 0.05, StepLinearSolver::kDirect);
  const auto pcg_step = MakeLinearlyImplicitEuler(model_, material_, 0.05, StepLinearSolver::kPcg);
  const auto float_step =
      MakeLinearlyImplicitEuler(model_, material_, 0.05, StepLinearSolver::kFloat);
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(direct_step(direct), IntegratorStatus::kOk);
    ASSERT_EQ(pcg_step(pcg), IntegratorStatus::kOk);
    ASSERT_EQ(float_step(single), IntegratorStatus::kOk);
  }
  const State expected = Fallen(5);
  EXPECT_EQ(direct.x, expected.x);
  EXPECT_LT((pcg.x - expected.x).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((single.x - expected.x).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_GT((single.x - expected.x).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_EQ(single.x, single.x.cast<float>().cast<double>());
}

TEST_F(IntegratorTest, ImplicitEulerSolvesItsEquation) {
  constexpr double kStep = 0.03;
  const auto step = MakeImplicitEuler(model_, material_, kStep);
  State state = Fallen(5);
  const State before = state;
  ASSERT_EQ(step(state), IntegratorStatus::kOk);
  Eigen::VectorXd force;
  AssembleForce(*model_, material_, state.x, force);
  const Eigen::VectorXd mass = model_->LumpedMass(material_.density);
  const Eigen::VectorXd momentum = mass.cwiseProduct(state.v - before.v);
  EXPECT_LT((force - momentum / kStep).norm(), 1e-8 * CharacteristicForce(*model_, material_));
  EXPECT_LT((state.x - before.x - kStep * state.v).norm(), 1e-12);
}

TEST_F(IntegratorTest, FailuresAreNamed) {
  State state = start_;
  EXPECT_EQ(MakeLinearlyImplicitEuler(model_, material_, 0.1, StepLinearSolver::kPcg,
                                      {.max_iterations = 1})(state),
            IntegratorStatus::kNotConverged);
  state = start_;
  EXPECT_EQ(MakeImplicitEuler(model_, material_, 0.1, {.max_iterations = 1})(state),
            IntegratorStatus::kNotConverged);
  MaterialField negative = material_;  // which no file reader lets pass
  for (double& entry : std::span(&negative.stretch[0].c[0][0], kStretchEntries)) entry *= -1.0;
  for (const StepLinearSolver system : {StepLinearSolver::kDirect, StepLinearSolver::kFloat}) {
    state = start_;
    EXPECT_EQ(MakeLinearlyImplicitEuler(model_, negative, 0.1, system)(state),
              IntegratorStatus::kNotPositiveDefinite);
  }
  for (const bool is_explicit : {true, false}) {
    state = start_;
    state.x[4] = std::numeric_limits<double>::quiet_NaN();
    const auto step = is_explicit ? MakeExplicitEuler(model_, material_, 1e-4, 0.0)
                                  : MakeImplicitEuler(model_, material_, 0.1);
    EXPECT_EQ(step(state), IntegratorStatus::kNotFinite);
  }
}

TEST_F(IntegratorTest, HighestEigenvalueAndShapesAgreeWithDenseAlgebra) {
  const Eigen::VectorXd x = Fallen(10).x;
  const Eigen::MatrixXd K = DenseStiffness(x);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> dense(K, DenseMass());
  StepSolver solver(model_);
  const std::optional<double> highest = HighestEigenvalue(solver, material_, x);
  ASSERT_TRUE(highest.has_value());
  EXPECT_NEAR(*highest, dense.eigenvalues().maxCoeff(), 1e-6 * *highest);
  const VibrationModes modes = LowestModes(solver, material_, x, 4);
  ASSERT_EQ(modes.eigenvalues.size(), 4);
  for (int i = 0; i < 4; ++i) {
    const Eigen::VectorXd shape = modes.shapes.col(i);
    EXPECT_NEAR(shape.dot(DenseMass() * shape), 1.0, 1e-8);
    EXPECT_NEAR(shape.dot(K * shape), modes.eigenvalues[i], 1e-6 * dense.eigenvalues()[10]);
    EXPECT_NEAR(modes.eigenvalues[i], dense.eigenvalues()[i], 1e-6 * dense.eigenvalues()[10]);
  }
}

TEST_F(IntegratorTest, ProjectedStiffnessIsAboveKAndNeverNegative) {
  const Eigen::VectorXd x = 0.9 * start_.x;  // compressed: K itself is indefinite
  BlockMatrix projected(model_->pattern);
  AssembleProjectedStiffness(*model_, material_, x, projected);
  const Eigen::MatrixXd P = Dense(model_->pattern, projected, 1.0), K = DenseStiffness(x);
  const auto lowest = [](const Eigen::MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .minCoeff();
  };
  EXPECT_LT(lowest(K), -1.0);
  EXPECT_GT(lowest(P), -1e-9);
  EXPECT_GT(lowest(P - K), -1e-9);
}

TEST_F(IntegratorTest, ProjectedNewtonFindsTheSameDrapeAndNoShiftNeedsLuck) {
  StepSolver solver(model_);
  const Eigen::VectorXd x = Fallen(100).x;
  const EquilibriumResult usual = SolveEquilibrium(solver, material_, x, {});
  const EquilibriumResult projected =
      SolveEquilibrium(solver, material_, x, {.max_iterations = 300, .shift = kNoShift},
                       [&](const Eigen::VectorXd& here, BlockMatrix& K) {
                         AssembleProjectedStiffness(*model_, material_, here, K);
                       });
  ASSERT_EQ(usual.status, EquilibriumStatus::kStable);
  ASSERT_EQ(projected.status, EquilibriumStatus::kStable) << projected.residual;
  EXPECT_LT((usual.x - projected.x).cwiseAbs().maxCoeff(), 1e-6);
  const EquilibriumResult compressed =
      SolveEquilibrium(solver, material_, 0.8 * start_.x, {.shift = kNoShift});
  EXPECT_EQ(compressed.status, EquilibriumStatus::kNotConverged);
  EXPECT_TRUE(EndedByFactorisation(compressed));
  EXPECT_FALSE(EndedByFactorisation(usual));
}

// The smallest height of a triangle by its longest side, 0.87 where all are equilateral.
double MinTriangleQuality(const Mesh& mesh) {
  double worst = 1.0;
  for (const Face& face : mesh.faces) {
    double longest = 0.0;
    for (int k = 0; k < 3; ++k)
      longest = std::max(
          longest, (mesh.uv.col(face.vertex[k]) - mesh.uv.col(face.vertex[(k + 1) % 3])).norm());
    worst = std::min(worst, 2.0 * face.area / (longest * longest));
  }
  return worst;
}

TEST(Slivers, NeedlesOfTheRatioAndTheSameOutline) {
  const Mesh disc = MakeDisc({.target_vertices = 100});
  double before = 1.0;
  for (const double ratio : {1.0, 0.1, 1e-3}) {
    const Mesh mesh = AddSliverTriangles(disc, 0.09, ratio);
    ASSERT_EQ(mesh.num_faces(), disc.num_faces());
    double shortest = 1.0, area = 0.0, disc_area = 0.0;
    for (int e = 0; e < disc.num_hinges(); ++e)
      shortest = std::min(shortest, mesh.hinges[e].rest_length / disc.hinges[e].rest_length);
    for (int f = 0; f < disc.num_faces(); ++f)
      area += mesh.faces[f].area, disc_area += disc.faces[f].area;
    EXPECT_NEAR(shortest, ratio, 1e-9);
    EXPECT_NEAR(area, disc_area, 1e-12);
    for (const int i : disc.boundary_loops[0]) EXPECT_EQ(mesh.uv.col(i), disc.uv.col(i));
    EXPECT_LE(MinTriangleQuality(mesh), before);
    before = MinTriangleQuality(mesh);
  }
  EXPECT_LT(before, 2e-3);
  EXPECT_INPUT_ERROR(AddSliverTriangles(disc, 0.2, 0.5), "no edge between the support and the hem");
}

}  // namespace
}  // namespace drape
