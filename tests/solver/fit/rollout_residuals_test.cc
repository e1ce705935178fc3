// SPDX-License-Identifier: Apache-2.0
// ∂residual/∂θ of the whole chain θ → tables → drape → outline against central differences.
#include "solver/fit/rollout_residuals.h"

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "losses/outline/outline.h"
#include "losses/readout/readouts.h"
#include "physics/cloth/state.h"
#include "physics/simulation/backend.h"
#include "physics/util/errors.h"
#include "solver/fit/protocol/field_fit.h"
#include "tests/physics/cloth_fixture.h"
#include "tests/solver/fake_backend.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

constexpr int kOutlineAngles = 72;

struct OutlineCase {
  SolveMode solve_mode;
  ParameterTying tying;
  double coupling;  // c12/√(c11·c22) of all rows; 0: as the fabric has it
  std::string name;
};

MaterialField Coupled(double coupling) {
  MaterialField material = test::TestMaterial();
  if (coupling > 0)
    for (auto& row : material.stretch[0].c) row[1] = coupling * std::sqrt(row[0] * row[2]);
  return material;
}

class OutlineJacobianTest : public testing::TestWithParam<OutlineCase> {
 protected:
  static void SetUpTestSuite() {
    backend_ = test::SmoothDisc(120);
    observations_ = new std::vector<Observation>;
    starts_ = new std::vector<State>;
    for (const uint64_t seed : {1, 2}) {
      const State start = test::RandomStart(backend_->model(), seed);
      const State drape = test::Settled(*backend_, test::TestMaterial(), start);
      observations_->push_back(test::MakeObservation(backend_->model().mesh, drape, kOutlineAngles,
                                                     std::to_string(seed)));
      starts_->push_back(drape);
    }
  }
  static void TearDownTestSuite() {
    delete observations_;
    delete starts_;
    backend_.reset();
  }

  // Residuals of both observations at θ, from the same starts each time.
  Eigen::VectorXd Residual(const Eigen::VectorXd& theta, RowMatrix* jacobian = nullptr) const {
    ResidualOptions options = test::CloseOutlineOptions();
    options.solve_mode = GetParam().solve_mode;
    options.rollout.h = 0.1;
    options.rollout.steps = 5;
    options.equilibrium.tolerance = 1e-12;
    options.sigma_px = 0.5;
    RolloutResiduals outlines =
        ObservationResiduals(backend_.get(), &parametrisation_, *observations_, *starts_, options);
    Eigen::Map<Eigen::VectorXd>(outlines.theta(), theta.size()) = theta;
    outlines.PrepareForEvaluation(jacobian != nullptr, true);
    Eigen::VectorXd residual(2 * kOutlineAngles);
    if (jacobian != nullptr) jacobian->resize(2 * kOutlineAngles, theta.size());
    EXPECT_TRUE(outlines.all_valid());
    for (int i = 0; i < 2; ++i) {
      residual.segment(i * kOutlineAngles, kOutlineAngles) = outlines.residual(i);
      if (jacobian != nullptr)
        jacobian->middleRows(i * kOutlineAngles, kOutlineAngles) = outlines.jacobian(i);
    }
    return residual;
  }

  static std::unique_ptr<Backend> backend_;
  static std::vector<Observation>* observations_;
  static std::vector<State>* starts_;
  const TableParametrisation parametrisation_{Coupled(GetParam().coupling), GetParam().tying};
};
std::unique_ptr<Backend> OutlineJacobianTest::backend_;
std::vector<Observation>* OutlineJacobianTest::observations_ = nullptr;
std::vector<State>* OutlineJacobianTest::starts_ = nullptr;

INSTANTIATE_TEST_SUITE_P(
    Product, OutlineJacobianTest,
    testing::Values(
        OutlineCase{SolveMode::kDynamic, ParameterTying::kScales, 0, "Dynamic2"},
        OutlineCase{SolveMode::kDynamic, ParameterTying::kColumns, 0, "Dynamic7"},
        OutlineCase{SolveMode::kDynamic, ParameterTying::kEntries, 0, "Dynamic39"},
        OutlineCase{SolveMode::kStatic, ParameterTying::kScales, 0, "Static2"},
        OutlineCase{SolveMode::kStatic, ParameterTying::kColumns, 0, "Static7"},
        OutlineCase{SolveMode::kStatic, ParameterTying::kEntries, 0, "Static39"},
        OutlineCase{SolveMode::kDynamic, ParameterTying::kEntries, 0.8, "DynamicCoupled39"},
        OutlineCase{SolveMode::kStatic, ParameterTying::kColumns, 0.8, "StaticCoupled7"},
        OutlineCase{SolveMode::kStatic, ParameterTying::kEntries, 0.8, "StaticCoupled39"}),
    [](const auto& info) { return info.param.name; });

// The best of a sweep: truncation falls with the step, rounding (and the equilibrium's tolerance)
// rises as 1/step. Measured: below 1e-7 at the best step, about 1e-5.
TEST_P(OutlineJacobianTest, AgreesWithCentralDifferences) {
  std::mt19937_64 random(11);
  const int size = parametrisation_.size();
  const Eigen::VectorXd theta = 0.02 * test::RandomMatrix(size, 1, random);
  const Eigen::VectorXd direction = test::RandomMatrix(size, 1, random);
  RowMatrix jacobian;
  Residual(theta, &jacobian);
  const Eigen::VectorXd exact = jacobian * direction;
  ASSERT_GT(exact.head(kOutlineAngles).norm(), 1.0);
  ASSERT_GT(exact.tail(kOutlineAngles).norm(), 1.0);
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
class OutlineFieldTest : public testing::Test {
 protected:
  OutlineFieldTest() {
    starts_ = {
        test::Settled(*backend_, test::TestMaterial(), test::RandomStart(backend_->model(), 1))};
    observations_ = {test::MakeObservation(mesh_, starts_[0], kOutlineAngles, "1")};
    options_.equilibrium.tolerance = 1e-12;
    options_.sigma_px = 0.5;
  }
  RolloutResiduals At(const Eigen::VectorXd& theta) {
    RolloutResiduals outlines =
        ObservationResiduals(backend_.get(), &fields_, observations_, starts_, options_);
    Eigen::Map<Eigen::VectorXd>(outlines.theta(), theta.size()) = theta;
    return outlines;
  }
  Eigen::VectorXd Residual(const Eigen::VectorXd& theta) {
    RolloutResiduals outlines = At(theta);
    outlines.PrepareForEvaluation(false, true);
    EXPECT_TRUE(outlines.valid(0));
    return outlines.residual(0);
  }

  const std::unique_ptr<Backend> backend_ = test::SmoothDisc(120);
  const Mesh& mesh_ = backend_->model().mesh;
  const FieldParametrisation fields_{test::TestMaterial(), mesh_.num_faces(), mesh_.num_hinges(),
                                     MakeFieldTerms(mesh_, {})};
  std::vector<Observation> observations_;
  std::vector<State> starts_;
  ResidualOptions options_ = test::CloseOutlineOptions();
  std::mt19937_64 random_{12};
};

TEST_F(OutlineFieldTest, JacobianAgreesWithCentralDifferences) {
  const Eigen::VectorXd theta = 0.02 * test::RandomMatrix(fields_.size(), 1, random_);
  const Eigen::VectorXd direction = test::RandomMatrix(fields_.size(), 1, random_);
  RolloutResiduals outlines = At(theta);
  outlines.PrepareForEvaluation(true, true);
  ASSERT_TRUE(outlines.has_accepted());
  const Eigen::VectorXd exact = outlines.accepted().jacobian * direction;
  double best = 1.0;
  for (double step = 1e-3; step > 1e-7; step /= 10) {
    const Eigen::VectorXd difference =
        (Residual(theta + step * direction) - Residual(theta - step * direction)) / (2 * step);
    best = std::min(best, (difference - exact).norm() / exact.norm());
  }
  EXPECT_LT(best, 1e-6);
}

// A hundredth of the step is a ten-thousandth of the error.
TEST_F(OutlineFieldTest, ShapesArePredictedToSecondOrder) {
  const Eigen::VectorXd direction = test::RandomMatrix(fields_.size(), 1, random_);
  options_.max_jump = 1e-7;
  RolloutResiduals outlines = At(Eigen::VectorXd::Zero(fields_.size()));
  outlines.PrepareForEvaluation(true, true);
  ASSERT_TRUE(outlines.has_accepted());
  for (const double step : {1e-2, 1e-4}) {
    Eigen::Map<Eigen::VectorXd>(outlines.theta(), direction.size()) = step * direction;
    outlines.PrepareForEvaluation(false, true);
  }
  EXPECT_EQ(outlines.counts().jumps, 1);  // the first
  EXPECT_GT((outlines.shape(0) - starts_[0].x).cwiseAbs().maxCoeff(), 1e-7);
}

// Many parameters go to Ceres's conjugate gradients: its first step is that of the dual system.
TEST_F(OutlineFieldTest, AStepOfManyNumbersIsThatOfTheDualSystem) {
  FieldOptions every;
  every.groups = FieldGroups::kEntries;
  const FieldParametrisation many(test::TestMaterial(), mesh_.num_faces(), mesh_.num_hinges(),
                                  MakeFieldTerms(mesh_, every));
  ASSERT_GT(many.size(), kMaxDenseParameters);
  RolloutResiduals outlines =
      ObservationResiduals(backend_.get(), &many, observations_, starts_, options_);
  outlines.PrepareForEvaluation(true, true);
  ASSERT_TRUE(outlines.has_accepted());
  constexpr double kDamping = 1e-2;
  const Eigen::MatrixXd jacobian = outlines.accepted().jacobian;
  Eigen::MatrixXd dual = jacobian * jacobian.transpose();
  dual.diagonal().array() += 1 + kDamping;
  const Eigen::VectorXd step =
      -jacobian.transpose() * dual.ldlt().solve(outlines.accepted().residual);
  FitOptions options;
  options.trust_region.max_iterations = 1;
  options.trust_region.unit_damping = true;
  options.trust_region.initial_damping = kDamping;
  const FitSummary summary = Fit(outlines, options);
  ASSERT_GT(summary.theta.norm(), 0.0);
  EXPECT_LT((summary.theta - step).norm(), 1e-4 * step.norm());
}

// Without physics: which points are kept and which rejected.
class RolloutResidualsTest : public testing::Test {
 protected:
  RolloutResidualsTest() {
    for (const double stretch : {0.1, 0.3}) {
      Observation observation;
      Outline outline;
      EXPECT_TRUE(OutlineFromMesh(backend_.model().mesh, Shape(stretch), observation.camera,
                                  kOutlineAngles, &outline));
      observation.radius = outline.radius;
      observations_.push_back(observation);
      starts_.push_back(backend_.model().RestState());
    }
    options_.max_jump = 5e-3;
  }
  Eigen::VectorXd Shape(double stretch) const {
    Eigen::VectorXd theta = Eigen::VectorXd::Zero(2);
    theta[0] = stretch;
    return backend_.Shape(parametrisation_.Material(theta));
  }
  RolloutResiduals Make() {
    return ObservationResiduals(&backend_, &parametrisation_, observations_, starts_, options_);
  }

  test::FakeBackend backend_;
  TableParametrisation parametrisation_{test::TestMaterial(), ParameterTying::kScales};
  std::vector<Observation> observations_;
  std::vector<State> starts_;
  ResidualOptions options_ = test::CloseOutlineOptions();
};

TEST_F(RolloutResidualsTest, SlicesBelongToTheirTargets) {
  RolloutResiduals outlines = Make();
  outlines.theta()[0] = 0.3;
  outlines.PrepareForEvaluation(false, true);
  ASSERT_TRUE(outlines.all_valid());
  EXPECT_LT(outlines.residual(0)[0],
            -1.0);  // the first image was made with a softer shrink: it is wider
  EXPECT_NEAR(outlines.residual(1)[0], 0.0, 1e-12);
}

TEST_F(RolloutResidualsTest, OnePointIsComputedOnce) {
  RolloutResiduals outlines = Make();
  outlines.PrepareForEvaluation(false, true);
  outlines.PrepareForEvaluation(false, false);
  EXPECT_EQ(backend_.equilibria, 2);
  EXPECT_EQ(outlines.counts().rollouts, 2);
  EXPECT_EQ(outlines.counts().tangents, 0);
}

TEST_F(RolloutResidualsTest, AJumpIsMeasuredFromTheLinearPrediction) {
  RolloutResiduals outlines = Make();
  outlines.PrepareForEvaluation(true, true);
  outlines.theta()[0] = 0.1;  // moves the hem by 3 mm, as predicted to 0.01 mm
  outlines.PrepareForEvaluation(false, true);
  EXPECT_TRUE(outlines.valid(0));
  EXPECT_EQ(outlines.counts().jumps, 0);
  backend_.other_branch = [](double, double) { return true; };
  outlines.theta()[0] = 0.1001;
  outlines.PrepareForEvaluation(false, true);
  EXPECT_FALSE(outlines.valid(0));
  EXPECT_EQ(outlines.counts().jumps, 2);
}

TEST_F(RolloutResidualsTest, AStepThatIsPredictedToGoTooFarIsRefusedWithoutARollout) {
  options_.max_outline_change = 1.0;
  RolloutResiduals outlines = Make();
  outlines.PrepareForEvaluation(true, true);
  const double px_per_unit = outlines.accepted().jacobian.col(0).norm() /
                             std::sqrt(double(outlines.accepted().jacobian.rows()));
  outlines.theta()[0] = 1.01 / px_per_unit;
  outlines.PrepareForEvaluation(false, true);
  EXPECT_FALSE(outlines.valid(0));
  EXPECT_EQ(outlines.counts().rollouts, 2);
  EXPECT_EQ(outlines.counts().capped, 1);
  outlines.theta()[0] = 0.99 / px_per_unit;
  outlines.PrepareForEvaluation(false, true);
  EXPECT_TRUE(outlines.valid(0));
  EXPECT_EQ(outlines.counts().rollouts, 4);
}

// However large c12 would be on a log scale of its own.
TEST_F(RolloutResidualsTest, NoTableIsRefused) {
  parametrisation_ = TableParametrisation(test::TestMaterial(), ParameterTying::kColumns);
  RolloutResiduals outlines = Make();
  for (const double c12 : {0.1, 5.0, 20.0}) {
    outlines.theta()[1] = c12;
    outlines.PrepareForEvaluation(false, true);
    EXPECT_TRUE(outlines.all_valid()) << c12;
  }
  EXPECT_EQ(outlines.counts().failed, 0);
}

TEST_F(RolloutResidualsTest, TheAcceptedPointOutlivesAFailure) {
  RolloutResiduals outlines = Make();
  EXPECT_FALSE(outlines.has_accepted());
  outlines.theta()[0] = 0.05;
  outlines.PrepareForEvaluation(true, true);
  ASSERT_TRUE(outlines.has_accepted());
  backend_.fails = [](double, double) { return true; };
  outlines.theta()[0] = 0.06;
  outlines.PrepareForEvaluation(true, true);
  EXPECT_FALSE(outlines.valid(0));
  EXPECT_EQ(outlines.counts().failed, 2);
  EXPECT_EQ(outlines.accepted().theta[0], 0.05);
  outlines.StartFromAccepted();
  EXPECT_EQ(outlines.starts()[1].x, Shape(0.05));
}

TEST(SolveMode, KnowsTwoNames) {
  EXPECT_EQ(ParseName<SolveMode>("dynamic", ""), SolveMode::kDynamic);
  EXPECT_EQ(ParseName<SolveMode>("static", ""), SolveMode::kStatic);
  EXPECT_THROW(ParseName<SolveMode>("Static", ""), InputError);
}

// Losses of images through the rollout: exact gradients against differences of the whole.

// L = ½ Σ_k ((r_k − target_k)/sigma)² of the numbers that `readout` finds at the end of a rollout.
struct Loss {
  const Readout& readout;
  Eigen::VectorXd target;
  double sigma;
};
struct LossGradient {
  double loss = 0.0;
  MaterialGradient material;
};

class LossGradientTest : public testing::Test {
 protected:
  LossGradientTest() {
    start_.x = ApplyStartShape(model_->mesh, DrapeDiscs().support, RandomStartShape(3, 3e-3));
    camera_.cx += 0.3;
  }
  LossGradient At(const MaterialField& material, const Loss& loss) const {
    const RolloutInput input{&material, &start_};
    const RolloutOptions options{.h = 0.05, .steps = 12};
    const auto backend = MakeCpuBackend(model_, 1);
    std::vector<Recording> recordings;
    const RolloutResult rollout = backend->Rollouts({&input, 1}, options, &recordings)[0];
    Eigen::VectorXd r;
    ReadoutJacobian dr_dx;
    EXPECT_EQ(rollout.status, RolloutStatus::kOk);
    EXPECT_TRUE(loss.readout.Read(rollout.end.x, &r, &dr_dx));
    const Eigen::VectorXd residual = (r - loss.target) / loss.sigma;
    const RowMatrix dL_dx = dr_dx.transpose() * (residual / loss.sigma);
    const auto adjoint = backend->Adjoints({&input, 1}, recordings, {&dL_dx, 1}, options)[0];
    return {0.5 * residual.squaredNorm(), adjoint.material};
  }
  // Along the logarithms of all entries. Truncation falls with h, rounding and the kinks of pixels
  // that change their nearest edge do not.
  void ExpectGradient(const Loss& loss, double tolerance) const {
    const MaterialField material = test::TestMaterial();
    const LossGradient exact = At(material, loss);
    const double along = exact.material.Contract(material).sum();
    double best = 1.0;
    for (const double h : {1e-3, 1e-4, 1e-5, 1e-6}) {
      MaterialField up = material, down = material;
      for (StretchTable& t : up.stretch)
        for (auto& row : t.c)
          for (double& c : row) c *= 1 + h;
      for (BendTable& t : up.bend)
        for (auto& row : t.b)
          for (double& b : row) b *= 1 + h;
      for (StretchTable& t : down.stretch)
        for (auto& row : t.c)
          for (double& c : row) c *= 1 - h;
      for (BendTable& t : down.bend)
        for (auto& row : t.b)
          for (double& b : row) b *= 1 - h;
      const double difference = (At(up, loss).loss - At(down, loss).loss) / (2 * h);
      best = std::min(best, std::abs(difference - along) / std::abs(along));
    }
    EXPECT_LT(best, tolerance);
  }

  std::shared_ptr<const ClothModel> model_ = test::SmallDisc("smooth", 150);
  State start_ = model_->RestState();
  Camera camera_;
};

TEST_F(LossGradientTest, OfTheOutline) {
  const OutlineReadout readout(model_->mesh, {camera_}, 72);
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(readout.size(), 100.0);
  ExpectGradient({readout, target, 2.0}, 1e-6);
}

TEST_F(LossGradientTest, OfTheSoftSilhouette) {
  const SilhouetteReadout readout(model_->mesh, {camera_}, {2.0});
  const Eigen::VectorXd target = Eigen::VectorXd::Constant(readout.size(), 0.4);
  ExpectGradient({readout, target, 0.5}, 1e-5);
}

}  // namespace
}  // namespace drape
