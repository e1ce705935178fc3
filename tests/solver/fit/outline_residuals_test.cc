// SPDX-License-Identifier: Apache-2.0
// ∂residual/∂θ of the whole chain θ → tables → drape → outline against central differences.
#include "solver/fit/outline_residuals.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstdio>

#include "physics/util/errors.h"
#include "solver/fit/protocol/field_fit.h"
#include "tests/solver/fake_backend.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr int kAngles = 72;

struct Case {
  SolveMode integrator;
  ParameterTying tying;
  std::string name;
};

class BatchJacobianTest : public testing::TestWithParam<Case> {
 protected:
  static void SetUpTestSuite() {
    backend_ = test::SmoothDisc(120);
    targets_ = new std::vector<Observation>;
    for (const uint64_t seed : {1, 2}) {
      const State start = test::RandomStart(backend_->model(), seed);
      const State drape = test::Settled(*backend_, test::TestMaterial(), start);
      targets_->push_back(
          test::MakeObservation(backend_->model().mesh, drape, kAngles, std::to_string(seed)));
    }
  }
  static void TearDownTestSuite() {
    delete targets_;
    backend_.reset();
  }

  // Residuals of both targets at θ, from the same starts each time.
  Eigen::VectorXd Residual(const Eigen::VectorXd& theta, RowMatrix* jacobian = nullptr) const {
    std::vector<Observation> targets = *targets_;
    OutlineResidualOptions options;
    options.integrator = GetParam().integrator;
    options.rollout.h = 0.1;
    options.rollout.steps = 5;
    options.equilibrium.tolerance = 1e-12;
    options.sigma_px = 0.5;
    OutlineResiduals batch(backend_.get(), &parametrisation_, &targets, options);
    Eigen::Map<Eigen::VectorXd>(batch.theta(), theta.size()) = theta;
    batch.PrepareForEvaluation(jacobian != nullptr, true);
    Eigen::VectorXd residual(2 * kAngles);
    if (jacobian != nullptr) jacobian->resize(2 * kAngles, theta.size());
    for (int i = 0; i < 2; ++i) {
      EXPECT_TRUE(batch.Copy(i, residual.data() + i * kAngles));
      if (jacobian != nullptr)
        batch.CopyJacobian(i, 0, batch.num_parameters(), jacobian->row(i * kAngles).data());
    }
    return residual;
  }

  static std::unique_ptr<Backend> backend_;
  static std::vector<Observation>* targets_;
  const TableParametrisation parametrisation_{test::TestMaterial(), GetParam().tying};
};
std::unique_ptr<Backend> BatchJacobianTest::backend_;
std::vector<Observation>* BatchJacobianTest::targets_ = nullptr;

INSTANTIATE_TEST_SUITE_P(
    Product, BatchJacobianTest,
    testing::Values(Case{SolveMode::kDynamic, ParameterTying::kScales, "Dynamic2"},
                    Case{SolveMode::kDynamic, ParameterTying::kColumns, "Dynamic7"},
                    Case{SolveMode::kDynamic, ParameterTying::kEntries, "Dynamic39"},
                    Case{SolveMode::kStatic, ParameterTying::kScales, "Static2"},
                    Case{SolveMode::kStatic, ParameterTying::kColumns, "Static7"},
                    Case{SolveMode::kStatic, ParameterTying::kEntries, "Static39"}),
    [](const auto& info) { return info.param.name; });

// The best of a sweep: truncation falls with the step, rounding (and the equilibrium's tolerance)
// rises as 1/step. Measured: below 1e-7 at the best step, about 1e-5.
TEST_P(BatchJacobianTest, AgreesWithCentralDifferences) {
  std::mt19937_64 random(11);
  const int size = parametrisation_.size();
  const Eigen::VectorXd theta = 0.02 * test::RandomMatrix(size, 1, random);
  const Eigen::VectorXd direction = test::RandomMatrix(size, 1, random);
  RowMatrix jacobian;
  Residual(theta, &jacobian);
  const Eigen::VectorXd exact = jacobian * direction;
  ASSERT_GT(exact.head(kAngles).norm(), 1.0);
  ASSERT_GT(exact.tail(kAngles).norm(), 1.0);
  double best = 1.0;
  for (double step = 1e-2; step > 1e-7; step /= 10) {
    const Eigen::VectorXd difference =
        (Residual(theta + step * direction) - Residual(theta - step * direction)) / (2 * step);
    best = std::min(best, (difference - exact).norm() / exact.norm());
  }
  std::printf("relative error of the best step: %.1e\n", best);
  EXPECT_LT(best, 1e-6);
}

// Fields have Jacobians by adjoints and predictions by one direction.
class BatchFieldTest : public testing::Test {
 protected:
  BatchFieldTest() {
    const State start = test::RandomStart(backend_->model(), 1);
    targets_ = {test::MakeObservation(mesh_, test::Settled(*backend_, test::TestMaterial(), start),
                                      kAngles, "1")};
    options_.equilibrium.tolerance = 1e-12;
    options_.sigma_px = 0.5;
  }
  OutlineResiduals At(const Eigen::VectorXd& theta) {
    OutlineResiduals batch(backend_.get(), &fields_, &targets_, options_);
    Eigen::Map<Eigen::VectorXd>(batch.theta(), theta.size()) = theta;
    return batch;
  }
  Eigen::VectorXd Residual(const Eigen::VectorXd& theta) {
    OutlineResiduals batch = At(theta);
    batch.PrepareForEvaluation(false, true);
    Eigen::VectorXd residual(kAngles);
    EXPECT_TRUE(batch.Copy(0, residual.data()));
    return residual;
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(120);
  const Mesh& mesh_ = backend_->model().mesh;
  const FieldParametrisation fields_{test::TestMaterial(), mesh_.num_faces(), mesh_.num_hinges(),
                                     MakeFieldTerms(mesh_, {})};
  std::vector<Observation> targets_;
  OutlineResidualOptions options_;
  std::mt19937_64 random_{12};
};

TEST_F(BatchFieldTest, JacobianAgreesWithCentralDifferences) {
  const Eigen::VectorXd theta = 0.02 * test::RandomMatrix(fields_.size(), 1, random_);
  const Eigen::VectorXd direction = test::RandomMatrix(fields_.size(), 1, random_);
  OutlineResiduals batch = At(theta);
  batch.PrepareForEvaluation(true, true);
  ASSERT_TRUE(batch.has_accepted());
  const Eigen::VectorXd exact = batch.accepted().jacobian * direction;
  double best = 1.0;
  for (double step = 1e-3; step > 1e-7; step /= 10) {
    const Eigen::VectorXd difference =
        (Residual(theta + step * direction) - Residual(theta - step * direction)) / (2 * step);
    best = std::min(best, (difference - exact).norm() / exact.norm());
  }
  EXPECT_LT(best, 1e-6);
}

// A hundredth of the step is a ten-thousandth of the error.
TEST_F(BatchFieldTest, ShapesArePredictedToSecondOrder) {
  const Eigen::VectorXd direction = test::RandomMatrix(fields_.size(), 1, random_);
  options_.max_jump = 1e-7;
  OutlineResiduals batch = At(Eigen::VectorXd::Zero(fields_.size()));
  batch.PrepareForEvaluation(true, true);
  ASSERT_TRUE(batch.has_accepted());
  for (const double step : {1e-2, 1e-4}) {
    Eigen::Map<Eigen::VectorXd>(batch.theta(), direction.size()) = step * direction;
    batch.PrepareForEvaluation(false, true);
  }
  EXPECT_EQ(batch.counts().jumps, 1);  // the first
  EXPECT_GT((batch.shape(0) - targets_[0].start.x).cwiseAbs().maxCoeff(), 1e-7);
}

// Many parameters go to Ceres's conjugate gradients: its first step is that of the dual system.
TEST_F(BatchFieldTest, AStepOfManyNumbersIsThatOfTheDualSystem) {
  FieldOptions every;
  every.groups = FieldGroups::kEntries;
  const FieldParametrisation many(test::TestMaterial(), mesh_.num_faces(), mesh_.num_hinges(),
                                  MakeFieldTerms(mesh_, every));
  ASSERT_GT(many.size(), kMostDenseParameters);
  OutlineResiduals batch(backend_.get(), &many, &targets_, options_);
  batch.PrepareForEvaluation(true, true);
  ASSERT_TRUE(batch.has_accepted());
  constexpr double kDamping = 1e-2;
  const Eigen::MatrixXd jacobian = batch.accepted().jacobian;
  Eigen::MatrixXd dual = jacobian * jacobian.transpose();
  dual.diagonal().array() += 1 + kDamping;
  const Eigen::VectorXd step = -jacobian.transpose() * dual.ldlt().solve(batch.accepted().residual);
  FitOptions options;
  options.max_iterations = 1;
  options.unit_damping = true;
  options.initial_damping = kDamping;
  const FitSummary summary = Fit(batch, options);
  ASSERT_GT(summary.theta.norm(), 0.0);
  EXPECT_LT((summary.theta - step).norm(), 1e-4 * step.norm());
}

// Without physics: what the batch keeps and refuses.
class BatchTest : public testing::Test {
 protected:
  BatchTest() {
    for (const double stretch : {0.1, 0.3}) {
      Observation target;
      Outline outline;
      EXPECT_TRUE(
          OutlineFromMesh(backend_.model().mesh, Shape(stretch), target.camera, kAngles, &outline));
      target.radius = outline.radius;
      target.start = backend_.model().RestState();
      targets_.push_back(target);
    }
    options_.max_jump = 5e-3;
  }
  Eigen::VectorXd Shape(double stretch) const {
    Eigen::VectorXd theta = Eigen::VectorXd::Zero(2);
    theta[0] = stretch;
    return backend_.Shape(parametrisation_.Material(theta));
  }
  OutlineResiduals Make() { return {&backend_, &parametrisation_, &targets_, options_}; }

  test::FakeBackend backend_;
  TableParametrisation parametrisation_{test::TestMaterial(), ParameterTying::kScales};
  std::vector<Observation> targets_;
  OutlineResidualOptions options_;
  std::array<double, kAngles> residual_ = {};
};

TEST_F(BatchTest, SlicesBelongToTheirTargets) {
  OutlineResiduals batch = Make();
  batch.theta()[0] = 0.3;
  batch.PrepareForEvaluation(false, true);
  ASSERT_TRUE(batch.Copy(0, residual_.data()));
  EXPECT_LT(residual_[0], -1.0);  // the first image was made with a softer shrink: it is wider
  ASSERT_TRUE(batch.Copy(1, residual_.data()));
  EXPECT_NEAR(residual_[0], 0.0, 1e-12);
}

TEST_F(BatchTest, OnePointIsComputedOnce) {
  OutlineResiduals batch = Make();
  batch.PrepareForEvaluation(false, true);
  batch.PrepareForEvaluation(false, false);
  EXPECT_EQ(backend_.equilibria, 2);
  EXPECT_EQ(batch.counts().rollouts, 2);
  EXPECT_EQ(batch.counts().tangents, 0);
}

TEST_F(BatchTest, AJumpIsMeasuredFromTheLinearPrediction) {
  OutlineResiduals batch = Make();
  batch.PrepareForEvaluation(true, true);
  batch.theta()[0] = 0.1;  // moves the hem by 3 mm, as predicted to 0.01 mm
  batch.PrepareForEvaluation(false, true);
  EXPECT_TRUE(batch.Copy(0, residual_.data()));
  EXPECT_EQ(batch.counts().jumps, 0);
  backend_.other_branch = [](double, double) { return true; };
  batch.theta()[0] = 0.1001;
  batch.PrepareForEvaluation(false, true);
  EXPECT_FALSE(batch.Copy(0, residual_.data()));
  EXPECT_EQ(batch.counts().jumps, 2);
}

TEST_F(BatchTest, AStepThatIsPredictedToGoTooFarIsRefusedWithoutARollout) {
  options_.max_outline_change = 1.0;
  OutlineResiduals batch = Make();
  batch.PrepareForEvaluation(true, true);
  const double px_per_unit =
      batch.accepted().jacobian.col(0).norm() / std::sqrt(double(batch.accepted().jacobian.rows()));
  batch.theta()[0] = 1.01 / px_per_unit;
  batch.PrepareForEvaluation(false, true);
  EXPECT_FALSE(batch.Copy(0, residual_.data()));
  EXPECT_EQ(batch.counts().rollouts, 2);
  EXPECT_EQ(batch.counts().capped, 1);
  batch.theta()[0] = 0.99 / px_per_unit;
  batch.PrepareForEvaluation(false, true);
  EXPECT_TRUE(batch.Copy(0, residual_.data()));
  EXPECT_EQ(batch.counts().rollouts, 4);
}

TEST_F(BatchTest, ATableThatDoesNotResistAllStrainsIsRefusedWithoutARollout) {
  parametrisation_ = TableParametrisation(test::TestMaterial(), ParameterTying::kColumns);
  OutlineResiduals batch = Make();
  batch.theta()[1] = 0.1;  // c12
  batch.PrepareForEvaluation(false, true);
  EXPECT_TRUE(batch.all_valid());
  const int before = backend_.equilibria;
  batch.theta()[1] = 20.0;
  batch.PrepareForEvaluation(false, true);
  EXPECT_FALSE(batch.all_valid());
  EXPECT_EQ(backend_.equilibria, before);
  EXPECT_EQ(batch.counts().failed, 2);
}

TEST_F(BatchTest, TheAcceptedPointOutlivesAFailure) {
  OutlineResiduals batch = Make();
  EXPECT_FALSE(batch.has_accepted());
  batch.theta()[0] = 0.05;
  batch.PrepareForEvaluation(true, true);
  ASSERT_TRUE(batch.has_accepted());
  backend_.fails = [](double, double) { return true; };
  batch.theta()[0] = 0.06;
  batch.PrepareForEvaluation(true, true);
  EXPECT_FALSE(batch.Copy(0, residual_.data()));
  EXPECT_EQ(batch.counts().failed, 2);
  EXPECT_EQ(batch.accepted().theta[0], 0.05);
  batch.StartFromAccepted();
  EXPECT_EQ(targets_[1].start.x, Shape(0.05));
}

TEST(ParseSolveMode, KnowsTwoNames) {
  EXPECT_EQ(ParseSolveMode("dynamic"), SolveMode::kDynamic);
  EXPECT_EQ(ParseSolveMode("static"), SolveMode::kStatic);
  EXPECT_THROW(ParseSolveMode("Static"), InputError);
}

}  // namespace
}  // namespace drape
