// SPDX-License-Identifier: Apache-2.0
// Damping and air [MODEL, M64, M65, M66]: closed forms of the discrete step, and derivatives.
#include "physics/cloth/assembly/dynamics.h"

#include <gmock/gmock.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdio>
#include <vector>

#include "physics/cloth/assembly/air_element.h"
#include "physics/cloth/assembly/assembly.h"
#include "physics/simulation/implicit_euler.h"
#include "physics/simulation/rollout.h"
#include "physics/simulation/textbook.h"
#include "tests/physics/cloth_fixture.h"

namespace drape {
namespace {

constexpr double kGravity = 9.8;

// A flat horizontal cloth that nothing holds.
std::shared_ptr<const ClothModel> FreeSheet(double gravity) {
  DiscOptions options;
  options.target_vertices = 100;
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -gravity);
  return std::make_shared<ClothModel>(MakeDisc(options), scene, MakeLaw("reference"));
}

// The velocity of all vertices after `steps` steps from a common one; checks that it is common.
Eigen::Vector3d Fall(double gravity, const Dynamics& moving, const Eigen::Vector3d& from, double h,
                     int steps) {
  const auto model = FreeSheet(gravity);
  StepSolver solver(model);
  MaterialField material = test::TestMaterial();
  material.dynamics = moving;
  State start = model->RestState();
  start.v = from.replicate(model->mesh.num_vertices(), 1);
  const RolloutResult result = Rollout(solver, material, start, {.h = h, .steps = steps});
  EXPECT_EQ(result.status, RolloutStatus::kOk);
  const Eigen::Vector3d common = result.end.v.head<3>();
  EXPECT_LT((result.end.v - common.replicate(model->mesh.num_vertices(), 1)).cwiseAbs().maxCoeff(),
            1e-9 * (1.0 + common.norm()));
  return common;
}

// v' = (v + hg)/(1 + hα), which goes to g/α.
TEST(DynamicsTest, FreeClothWithMassDampingFallsAsTheRecursion) {
  const double h = 0.05, alpha = 3.0;
  double v = 0.0;
  for (const int steps : {1, 5, 200}) {
    v = 0.0;
    for (int k = 0; k < steps; ++k) v = (v - h * kGravity) / (1.0 + h * alpha);
    EXPECT_NEAR(Fall(kGravity, {.mass_damping = alpha}, {0, 0, 0}, h, steps).z(), v, 1e-9);
  }
  EXPECT_NEAR(v, -kGravity / alpha, 1e-9);
}

// ρv' = ρ(v + hg) − hc√(v² + ε²)·v' of a horizontal sheet, which goes to c·√(U² + ε²)·U = ρg.
TEST(DynamicsTest, HorizontalSheetFallsThroughAirAsTheRecursion) {
  const double h = 0.05, c = 0.9, rho = test::TestMaterial().density;
  double v = 0.0;
  for (const int steps : {1, 5, 200}) {
    v = 0.0;
    for (int k = 0; k < steps; ++k)
      v = (v - h * kGravity) / (1.0 + h * c / rho * std::hypot(v, kAirCreep));
    EXPECT_NEAR(Fall(kGravity, {.air_drag = c}, {0, 0, 0}, h, steps).z(), v, 1e-9);
  }
  const double e2 = kAirCreep * kAirCreep, square = rho * kGravity / c;
  EXPECT_NEAR(v, -std::sqrt(0.5 * (std::sqrt(e2 * e2 + 4 * square * square) - e2)), 1e-9);
}

TEST(DynamicsTest, WindOfTheSpeedOfTheClothPushesNothing) {
  const Eigen::Vector3d wind(0.7, -0.4, 1.3);
  const Eigen::Vector3d v =
      Fall(0.0, {.air_drag = 2.0, .wind = {wind.x(), wind.y(), wind.z()}}, wind, 0.05, 10);
  EXPECT_LT((v - wind).norm(), 1e-12);
}

// Air slips along the cloth; across, the cloth goes with it in the end.
TEST(DynamicsTest, WindPushesAcrossTheClothOnly) {
  const Eigen::Vector3d v =
      Fall(0.0, {.air_drag = 2.0, .wind = {3.0, -2.0, 1.5}}, {0, 0, 0}, 0.05, 400);
  EXPECT_LT(v.head<2>().norm(), 1e-9);
  EXPECT_NEAR(v.z(), 1.5, 0.01);  // the rest decays with the inverse of time
}

// A mode of small vibrations, Kφ = ω²Mφ: each is one number q with velocity p, and
// (1 + hα + (h² + hβ)ω²)·p' = p − hω²q, q' = q + hp'.
TEST(DynamicsTest, ModesDecayAsImplicitEulerWithDamping) {
  const auto model = FreeSheet(0.0);
  const MaterialField undamped = LinearMaterial(50.0, 1e-4, 0.2);
  MaterialField material = undamped;
  material.dynamics = {.mass_damping = 0.8, .stiffness_damping = 0.013};
  const Eigen::VectorXd mass = model->LumpedMass(undamped.density);
  BlockMatrix A(model->pattern);
  Eigen::VectorXd force;
  AssembleStep(*model, undamped, model->mesh.rest_x, 1.0, force, A);
  const int n = model->num_dofs();
  RowMatrix dense = RowMatrix::Zero(n, n);
  AddMultiply(model->pattern, A, RowMatrix::Identity(n, n), dense);
  dense.diagonal() -= mass;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(
      dense, Eigen::MatrixXd(mass.asDiagonal()));
  StepSolver solver(model);
  const RolloutOptions options{.h = 0.01, .steps = 12};
  for (const int k : {20, n / 2, n - 1}) {  // bend, and stretch
    const double square = modes.eigenvalues()[k], size = 1e-7;
    const Eigen::VectorXd mode = modes.eigenvectors().col(k);
    State start = model->RestState();
    start.x += size * mode;
    const State end = Rollout(solver, material, start, options).end;
    double q = size, p = 0.0;
    for (int i = 0; i < options.steps; ++i) {
      p = (p - options.h * square * q) /
          (1.0 + options.h * 0.8 + (options.h * options.h + options.h * 0.013) * square);
      q += options.h * p;
    }
    EXPECT_GT(square, 10.0);
    const double found = mode.dot(mass.cwiseProduct(end.x - model->mesh.rest_x));
    EXPECT_NEAR(found, q, 1e-5 * size) << "omega " << std::sqrt(square);
    EXPECT_NEAR(mode.dot(mass.cwiseProduct(end.v)), p, 1e-4 * size * std::sqrt(square));
  }
}

TEST(DynamicsTest, NothingThatActsChangesNoBit) {
  std::mt19937_64 random(5);
  const auto model = test::SmallDisc("smooth");
  StepSolver solver(model);
  const State start = test::NoisyStart(*model, 1e-3, random);
  MaterialField windy = test::TestMaterial();
  windy.dynamics.wind = {4.0, 5.0, 6.0};
  EXPECT_FALSE(windy.dynamics.Acts());
  const State a = Rollout(solver, test::TestMaterial(), start, {.steps = 5}).end;
  const State b = Rollout(solver, windy, start, {.steps = 5}).end;
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.v, b.v);
}

TEST(DynamicsDeathTest, ImplicitEulerToConvergenceHasNone) {
  MaterialField material = test::TestMaterial();
  material.dynamics.mass_damping = 1.0;
  EXPECT_DEATH(ImplicitEuler(test::SmallDisc("smooth"), material, 0.05, {}), "damping and air");
}

// A cloth in motion whose tangents have the seven columns of dynamics and three of a common initial
// velocity.
struct DampedCase {
  std::string law;
  Dynamics moving;
};
class DynamicsDerivativeTest : public testing::TestWithParam<DampedCase> {
 protected:
  DynamicsDerivativeTest() {
    material_.dynamics = GetParam().moving;
    start_ = test::NoisyStart(*model_, 1e-3, random_);
    start_.v = 0.3 * test::RandomMatrix(model_->num_dofs(), 1, random_);
    more_.dynamics = true;
    more_.start_dv = Eigen::Matrix3d::Identity().replicate(model_->mesh.num_vertices(), 1);
  }
  // The end after one of the ten numbers has changed.
  Eigen::VectorXd End(int number, double change) {
    MaterialField material = material_;
    State start = start_;
    Dynamics& d = material.dynamics;
    double* const numbers[] = {&material.density, &d.mass_damping, &d.stiffness_damping,
                               &d.air_drag,       &d.wind.x,       &d.wind.y,
                               &d.wind.z};
    if (number < kDynamicsEntries)
      *numbers[number] += change;
    else
      start.v += change * more_.start_dv.col(number - kDynamicsEntries);
    return Rollout(solver_, material, start, options_).end.x;
  }

  std::mt19937_64 random_{31};
  std::shared_ptr<const ClothModel> model_ = test::SmallDisc(GetParam().law);
  StepSolver solver_{model_};
  MaterialField material_ = test::TestMaterial();
  State start_;
  TangentOptions more_;
  RolloutOptions options_{.h = 0.05, .steps = 8};
};

INSTANTIATE_TEST_SUITE_P(Product, DynamicsDerivativeTest,
                         testing::Values(DampedCase{"smooth", {}}, DampedCase{"reference", {}},
                                         DampedCase{"smooth", {0.7, 0.0, 0.0, {}}},
                                         DampedCase{"smooth", {0.0, 5e-3, 0.0, {}}},
                                         DampedCase{"smooth", {0.0, 0.0, 0.8, {1.0, 0.3, -0.6}}},
                                         DampedCase{"smooth", {0.7, 5e-3, 0.8, {1.0, 0.3, -0.6}}},
                                         DampedCase{"reference",
                                                    {0.7, 5e-3, 0.8, {1.0, 0.3, -0.6}}}));

TEST_P(DynamicsDerivativeTest, EachNumberAgreesWithFiniteDifferences) {
  const TangentResult tangent =
      RolloutTangent(solver_, material_, material_, start_, options_, more_);
  ASSERT_EQ(tangent.rollout.status, RolloutStatus::kOk);
  ASSERT_EQ(tangent.dx.cols(), kMaterialEntries + kDynamicsEntries + 3);
  for (int number = 0; number < kDynamicsEntries + 3; ++number) {
    const Eigen::VectorXd exact = tangent.dx.col(kMaterialEntries + number);
    if (number >= kByWind && number < kDynamicsEntries && GetParam().moving.air_drag == 0.0) {
      EXPECT_EQ(exact.norm(), 0.0);
      continue;
    }
    double best = 1.0;
    for (double step = 1e-3; step > 0.5e-7; step /= 10) {
      // A kink of the reference law can lie within a large step, rounding spoils a small one.
      const Eigen::VectorXd difference = (End(number, step) - End(number, -step)) / (2 * step);
      best = std::min(best, (difference - exact).norm() / exact.norm());
    }
    std::printf("number %d: |dx| %.2e, best error %.1e\n", number, exact.norm(), best);
    EXPECT_LT(best, 1e-6) << number;
    EXPECT_GT(exact.norm(), 0.0) << number;
  }
}

// By the tables, with damping and air: along one direction of all logarithms.
TEST_P(DynamicsDerivativeTest, TablesAgreeWithFiniteDifferences) {
  const TangentResult tangent =
      RolloutTangent(solver_, material_, material_, start_, options_, more_);
  const Eigen::VectorXd direction = test::RandomMatrix(kMaterialEntries, 1, random_);
  const Eigen::VectorXd exact = tangent.dx.leftCols(kMaterialEntries) * direction;
  const MaterialField middle = material_;
  const auto end = [&](double step) {
    material_ = middle;
    for (int k = 0; k < kStretchEntries; ++k)
      material_.stretch[0].entries()[k] *= std::exp(step * direction[k]);
    for (int k = 0; k < kBendEntries; ++k)
      material_.bend[0].entries()[k] *= std::exp(step * direction[kStretchEntries + k]);
    return End(0, 0.0);
  };
  double best = 1.0;
  for (double step = 1e-4; step > 0.5e-7; step /= 10)
    best = std::min(best, ((end(step) - end(-step)) / (2 * step) - exact).norm() / exact.norm());
  EXPECT_LT(best, 1e-6);
}

TEST_P(DynamicsDerivativeTest, AdjointAgreesWithTangentTo1em10) {
  const TangentResult tangent =
      RolloutTangent(solver_, material_, material_, start_, options_, more_);
  Recording recording;
  (void)Rollout(solver_, material_, start_, options_, &recording);
  for (const int m : {1, 3}) {
    const RowMatrix u = test::RandomMatrix(model_->num_dofs(), m, random_);
    const RowMatrix expected = tangent.dx.transpose() * u;
    const AdjointResult found =
        RolloutAdjoint(solver_, material_, options_, recording, u, {.dynamics = true});
    RowMatrix all(expected.rows(), m);
    all << found.material.Contract(material_), found.dynamics,
        more_.start_dv.transpose() * found.v0;
    for (int row = 0; row < expected.rows(); ++row)
      EXPECT_LT((all - expected).row(row).norm(),
                1e-10 * expected.row(row).norm() + 1e-14 * expected.norm())
          << row;
    EXPECT_EQ(RolloutAdjoint(solver_, material_, options_, recording, u).dynamics.size(), 0);
  }
}

// By the positions of the start, through the normals that the air acts on.
TEST_P(DynamicsDerivativeTest, StartAgreesWithFiniteDifferences) {
  const RowMatrix along = test::RandomMatrix(model_->num_dofs(), 1, random_);
  more_ = {.start_dx = along};
  const Eigen::VectorXd exact =
      RolloutTangent(solver_, material_, material_, start_, options_, more_)
          .dx.col(kMaterialEntries);
  double best = 1.0;
  for (double step = 1e-5; step > 0.5e-9; step /= 10) {
    const auto end = [&](double sign) {
      State start = start_;
      start.x += sign * step * along;
      return Rollout(solver_, material_, start, options_).end.x;
    };
    best = std::min(best, ((end(1) - end(-1)) / (2 * step) - exact).norm() / exact.norm());
  }
  EXPECT_LT(best, 1e-6);
}

// Contact is not damped: it sees the velocity itself, with one gradient and with several.
TEST(DampedContactTest, DerivativesOfClothOnAPlaneAgree) {
  std::mt19937_64 random(7);
  DiscOptions disc;
  disc.target_vertices = 100;
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.5, 0.0, -kGravity);
  scene.contact.emplace();
  scene.contact->obstacles.emplace_back(PlaneObstacle{.offset = -6e-4});  // gap .8 of the range
  const auto model = std::make_shared<ClothModel>(MakeDisc(disc), scene, MakeLaw("smooth"));
  StepSolver solver(model);
  MaterialField material = test::TestMaterial();
  material.dynamics = {0.7, 4e-3, 0.8, {1.0, 0.3, -0.6}};
  State start = test::NoisyStart(*model, 2e-5, random);
  start.v = 0.02 * test::RandomMatrix(model->num_dofs(), 1, random);
  const RolloutOptions options{.h = 2e-3, .steps = 6};
  const TangentResult tangent =
      RolloutTangent(solver, material, material, start, options, {.dynamics = true});
  ASSERT_EQ(tangent.rollout.status, RolloutStatus::kOk);
  const Eigen::VectorXd direction = test::RandomMatrix(kMaterialEntries, 1, random);
  const Eigen::VectorXd exact = tangent.dx.leftCols(kMaterialEntries) * direction;
  const auto end = [&](double step) {
    MaterialField moved = material;
    for (int k = 0; k < kStretchEntries; ++k)
      moved.stretch[0].entries()[k] *= std::exp(step * direction[k]);
    for (int k = 0; k < kBendEntries; ++k)
      moved.bend[0].entries()[k] *= std::exp(step * direction[kStretchEntries + k]);
    return Rollout(solver, moved, start, options).end.x;
  };
  double best = 1.0;
  for (double step = 1e-3; step > 0.5e-6; step /= 10)
    best = std::min(best, ((end(step) - end(-step)) / (2 * step) - exact).norm() / exact.norm());
  EXPECT_LT(best, 1e-6);
  Recording recording;
  (void)Rollout(solver, material, start, options, &recording);
  for (const int m : {1, 3}) {
    const RowMatrix u = test::RandomMatrix(model->num_dofs(), m, random);
    const AdjointResult adjoint =
        RolloutAdjoint(solver, material, options, recording, u, {.dynamics = true});
    RowMatrix found(tangent.dx.cols(), m);
    found << adjoint.material.Contract(material), adjoint.dynamics;
    const RowMatrix expected = tangent.dx.transpose() * u;
    for (int row = 0; row < expected.rows(); ++row)
      EXPECT_LT((found - expected).row(row).norm(),
                1e-10 * expected.row(row).norm() + 1e-14 * expected.norm())
          << row;
  }
}

}  // namespace
}  // namespace drape
