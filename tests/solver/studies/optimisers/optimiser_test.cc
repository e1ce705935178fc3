// SPDX-License-Identifier: Apache-2.0
// The meter, and each method on problems whose minimum is known.
#include "solver/studies/optimisers/methods/optimiser.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "solver/studies/optimisers/drape_function.h"
#include "tests/physics/file_fixture.h"
#include "tests/solver/fake_backend.h"
#include "tests/solver/solver_fixture.h"

namespace drape {
namespace {

// Rosenbrock's valley (1960) with its minimum 0 at `minimum`, θ = 0 on the valley's other side.
class Valley final : public ResidualFunction {
 public:
  int size() const override { return 2; }
  int num_residuals() const override { return 2; }
  bool Evaluate(const Eigen::VectorXd& theta, Eigen::VectorXd* residual,
                RowMatrix* jacobian) override {
    ++calls;
    if (theta[0] > fails_beyond) return false;
    residual->resize(2);
    *residual << 3.0 * (theta[1] - theta[0] * theta[0]), 1.0 - theta[0];
    if (jacobian == nullptr) return true;
    jacobian->resize(2, 2);
    *jacobian << -6.0 * theta[0], 3.0, -1.0, 0.0;
    return true;
  }
  double fails_beyond = std::numeric_limits<double>::infinity();
  int calls = 0;
};

OptimiserOptions ManyEvaluations() {
  OptimiserOptions options;
  options.budget = 3000.0;
  options.published_rates = Eigen::Vector2d(0.05, 0.05);
  return options;
}

class EachOptimiser : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    for (const OptimiserMethod& method : OptimiserMethods())
      if (method.name == GetParam() && !method.available)
        GTEST_SKIP() << "this build is without NLopt";
  }
};

TEST_P(EachOptimiser, FindsTheEndOfAValley) {
  Valley valley;
  const OptimiserRun run = RunOptimiser(GetParam(), valley, ManyEvaluations());
  ASSERT_EQ(run.theta.size(), 2);
  EXPECT_NEAR(run.theta[0], 1.0, 0.02) << run.cost;
  EXPECT_NEAR(run.theta[1], 1.0, 0.04);
  EXPECT_DOUBLE_EQ(run.trace.front().cost, 0.5);
  EXPECT_DOUBLE_EQ(run.trace.back().cost, run.cost);
  for (std::size_t i = 1; i < run.trace.size(); ++i) {
    EXPECT_LT(run.trace[i].cost, run.trace[i - 1].cost);
    EXPECT_GT(run.trace[i].spent, run.trace[i - 1].spent);
  }
}

TEST_P(EachOptimiser, SpendsNoMoreThanItsBudget) {
  Valley valley;
  OptimiserOptions options = ManyEvaluations();
  options.budget = 17.0;
  options.jacobian_cost_units = 2.5;
  const OptimiserRun run = RunOptimiser(GetParam(), valley, options);
  EXPECT_LT(run.spent, options.budget + 2.5);
  EXPECT_DOUBLE_EQ(run.spent, run.evaluations + 2.5 * run.jacobians);
  EXPECT_EQ(valley.calls, run.evaluations + run.jacobians);
  EXPECT_FALSE(run.cancelled);
}

TEST_P(EachOptimiser, LivesWithPointsThatCannotBeEvaluated) {
  Valley valley;
  valley.fails_beyond = 0.7;
  const OptimiserRun run = RunOptimiser(GetParam(), valley, ManyEvaluations());
  ASSERT_EQ(run.theta.size(), 2);
  EXPECT_LE(run.theta[0], 0.7);
  EXPECT_LT(run.cost, 0.2);  // 0.045 at the edge, 0.5 at the start
}

TEST_P(EachOptimiser, EndsAtOnceWhenCancelled) {
  Valley valley;
  OptimiserOptions options = ManyEvaluations();
  const std::atomic<bool> cancel = true;
  options.cancel = &cancel;
  EXPECT_TRUE(RunOptimiser(GetParam(), valley, options).cancelled);
  EXPECT_EQ(valley.calls, 0);
}

INSTANTIATE_TEST_SUITE_P(All, EachOptimiser,
                         testing::Values("lm", "lm_patient", "dogleg", "subspace_dogleg", "lbfgs",
                                         "adam_published", "adam_0.03", "adam_0.1", "bobyqa",
                                         "sbplx", "crs", "direct"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

TEST(Optimiser, UnknownNamesAreListed) {
  EXPECT_INPUT_ERROR(FindOptimiser("newton"),
                     "unknown name 'newton', expected some of lm, lm_patient");
}

TEST(BudgetedFunction, PaysOnceForAPoint) {
  Valley valley;
  OptimiserOptions options = ManyEvaluations();
  options.jacobian_cost_units = 4.0;
  BudgetedFunction metered(valley, options);
  Eigen::VectorXd residual;
  RowMatrix jacobian;
  const Eigen::Vector2d here(0.5, 0.0), there(0.5, 1.0);
  ASSERT_TRUE(metered.Evaluate(here, &residual, nullptr));
  ASSERT_TRUE(metered.Evaluate(here, &residual, &jacobian));
  ASSERT_TRUE(metered.Evaluate(here, &residual, &jacobian));
  EXPECT_DOUBLE_EQ(metered.run().spent, 5.0);
  ASSERT_TRUE(metered.Evaluate(there, &residual, &jacobian));
  EXPECT_DOUBLE_EQ(metered.run().spent, 10.0);
  EXPECT_DOUBLE_EQ(jacobian(0, 0), -3.0);
}

TEST(BudgetedFunction, RefusesWhatCannotBePaid) {
  Valley valley;
  OptimiserOptions options;
  options.budget = 2.0;
  BudgetedFunction metered(valley, options);
  Eigen::VectorXd residual;
  for (int i = 0; i < 2; ++i)
    EXPECT_TRUE(metered.Evaluate(Eigen::Vector2d(i, 0), &residual, nullptr));
  EXPECT_TRUE(metered.exhausted());
  EXPECT_FALSE(metered.Evaluate(Eigen::Vector2d(2, 0), &residual, nullptr));
  EXPECT_EQ(valley.calls, 2);
}

// The residuals and their derivatives are those of the fit's outlines, the prior's among them.
TEST(DrapeFunction, IsTheCostOfAFit) {
  test::FakeBackend backend;
  const TableParametrisation parametrisation(test::TestMaterial(), ParameterTying::kScales);
  const State rest = backend.model().RestState();
  std::vector<Observation> observations = {
      test::MakeObservation(backend.model().mesh, rest, 36, "flat")};
  OutlineResidualOptions options = test::CloseOutlineOptions();
  options.sigma_px = 0.5;
  DrapeFunction function(&backend, &parametrisation, &observations, {rest}, options, 2.0);
  ASSERT_EQ(function.num_residuals(), 36 + 2);
  Eigen::VectorXd residual, moved;
  RowMatrix jacobian;
  const Eigen::Vector2d theta(0.1, -0.2);
  ASSERT_TRUE(function.Evaluate(theta, &residual, &jacobian));
  EXPECT_DOUBLE_EQ(residual[36], 0.05);
  EXPECT_DOUBLE_EQ(residual[37], -0.1);
  EXPECT_EQ(function.best_shapes().size(), 1u);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(function.Evaluate(theta + kStep * Eigen::Vector2d::Unit(i), &moved, nullptr));
    EXPECT_LT(((moved - residual) / kStep - jacobian.col(i)).cwiseAbs().maxCoeff(), 1e-3) << i;
  }
}

// A step that is predicted to go too far is refused without a rollout.
TEST(DrapeFunction, ARefusalBeforeTheRolloutIsFree) {
  test::FakeBackend backend;
  const TableParametrisation parametrisation(test::TestMaterial(), ParameterTying::kScales);
  std::vector<Observation> observations = {
      test::MakeObservation(backend.model().mesh, backend.model().RestState(), 36, "flat")};
  OutlineResidualOptions options = test::CloseOutlineOptions();
  options.max_outline_change = 1.0;
  DrapeFunction function(&backend, &parametrisation, &observations, {backend.model().RestState()},
                         options, 1.0);
  OptimiserOptions optimiser;
  BudgetedFunction metered(function, optimiser);
  Eigen::VectorXd residual;
  RowMatrix jacobian;
  ASSERT_TRUE(metered.Evaluate(Eigen::Vector2d::Zero(), &residual, &jacobian));
  EXPECT_FALSE(metered.Evaluate(Eigen::Vector2d(2.0, 0.0), &residual, nullptr));
  EXPECT_EQ(metered.run().evaluations, 2);
  EXPECT_DOUBLE_EQ(metered.run().spent, 2.0);
}

TEST(DrapeFunction, SaysWhereThereIsNoDrape) {
  test::FakeBackend backend;
  backend.fails = [](double stretch, double) { return stretch > 0.5; };
  const TableParametrisation parametrisation(test::TestMaterial(), ParameterTying::kScales);
  std::vector<Observation> observations = {
      test::MakeObservation(backend.model().mesh, backend.model().RestState(), 36, "flat")};
  DrapeFunction function(&backend, &parametrisation, &observations, {backend.model().RestState()},
                         test::CloseOutlineOptions(), 1.0);
  Eigen::VectorXd residual;
  EXPECT_TRUE(function.Evaluate(Eigen::Vector2d(0.4, 0.0), &residual, nullptr));
  EXPECT_FALSE(function.Evaluate(Eigen::Vector2d(0.6, 0.0), &residual, nullptr));
}

}  // namespace
}  // namespace drape
