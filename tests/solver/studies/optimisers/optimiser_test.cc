// SPDX-License-Identifier: Apache-2.0
// The meter, and each method on problems whose minimum is known.
#include "solver/studies/optimisers/optimiser.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "solver/studies/optimisers/optimiser_study.h"
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
  options.search_command = {
      "/usr/bin/python3", "-B",
      std::string(DRAPE_SOURCE_DIR) + "/tools/programs/studies/scripts/search.py"};
  return options;
}

// Methods with a Gaussian process take a time that grows with the cube of the evaluations.
bool HasGaussianProcess(const std::string& method) {
  return method.starts_with("bo_") || method == "bo" || method.starts_with("rembo") ||
         method.starts_with("hesbo");
}
bool IsRefined(const std::string& method) { return method.ends_with("_lm"); }

OptimiserOptions EnoughEvaluations(const std::string& method) {
  OptimiserOptions options = ManyEvaluations();
  if (HasGaussianProcess(method)) options.budget = 75.0;
  return options;
}

std::vector<std::string> MethodNames() {
  std::vector<std::string> names;
  for (const OptimiserMethod& method : OptimiserMethods()) names.push_back(method.name);
  return names;
}

// One of each family of the search script.
std::vector<std::string> TestedNames() {
  std::vector<std::string> names = MethodNames();
  std::erase_if(names, [](const std::string& name) {
    const bool embedded = name.starts_with("rembo") || name.starts_with("hesbo");
    return embedded && !name.starts_with("hesbo_4") && name != "rembo_2" && name != "rembo_ucb_4";
  });
  return names;
}

std::vector<std::string> ConvergingNames() {
  std::vector<std::string> names;
  for (const std::string& name : TestedNames())
    if (!HasGaussianProcess(name) || IsRefined(name)) names.push_back(name);
  return names;
}

std::string TestName(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

class EachOptimiser : public testing::TestWithParam<std::string> {};

// A Gaussian process converges to the spacing of its candidates only.
class EachConvergingOptimiser : public EachOptimiser {};

TEST_P(EachConvergingOptimiser, FindsTheEndOfAValley) {
  Valley valley;
  const OptimiserRun run = RunOptimiser(GetParam(), valley, EnoughEvaluations(GetParam()));
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
  const OptimiserRun run = RunOptimiser(GetParam(), valley, EnoughEvaluations(GetParam()));
  ASSERT_EQ(run.theta.size(), 2);
  EXPECT_LE(run.theta[0], 0.7);
  // 0.045 at the edge, 0.5 at the start. An embedding may have both numbers on one line, or nearly
  // all points in the corners.
  const bool embedded = GetParam().starts_with("rembo") || GetParam().starts_with("hesbo");
  EXPECT_LE(run.cost, embedded && !IsRefined(GetParam()) ? 0.5 : 0.2);
}

TEST_P(EachOptimiser, EndsAtOnceWhenCancelled) {
  Valley valley;
  OptimiserOptions options = ManyEvaluations();
  const std::atomic<bool> cancel = true;
  options.cancel = &cancel;
  EXPECT_TRUE(RunOptimiser(GetParam(), valley, options).cancelled);
  EXPECT_EQ(valley.calls, 0);
}

INSTANTIATE_TEST_SUITE_P(All, EachOptimiser, testing::ValuesIn(TestedNames()), TestName);
INSTANTIATE_TEST_SUITE_P(All, EachConvergingOptimiser, testing::ValuesIn(ConvergingNames()),
                         TestName);

TEST(Optimiser, TheListHasTheMethodsOfTheStudy) {
  for (const char* name : {"lm", "bobyqa", "direct_lm", "cmaes", "cmaes_lm", "bo", "bo_lm",
                           "rembo_2", "rembo_4_lm", "rembo_ucb_4", "hesbo_8", "hesbo_8_lm"})
    EXPECT_THAT(MethodNames(), testing::Contains(name));
  EXPECT_EQ(FindOptimiser("hesbo_4_lm").search, "hesbo_4");
  EXPECT_TRUE(FindOptimiser("hesbo_4_lm").random);
  EXPECT_FALSE(FindOptimiser("lm").random);
  EXPECT_THAT(MethodNames(), testing::Not(testing::Contains("lm_lm")));
}

// All that a random method does follows from its seed.
TEST(Optimiser, RunsOfOneSeedAreTheSame) {
  for (const char* name : {"cmaes", "bo", "rembo_2", "hesbo_4", "hesbo_4_lm"}) {
    OptimiserOptions options = EnoughEvaluations(name);
    options.budget = IsRefined(name) ? 60.0 : 30.0;
    std::vector<double> costs;
    for (const int seed : {1, 1, 2}) {
      Valley valley;
      options.seed = seed;
      costs.push_back(RunOptimiser(name, valley, options).cost);
    }
    EXPECT_EQ(costs[0], costs[1]) << name;
    EXPECT_NE(costs[0], costs[2]) << name;
  }
}

// Without derivatives a budget in whole evaluations is spent to the last one and no further.
TEST(Optimiser, BudgetsAreKeptExactly) {
  for (const char* name : {"cmaes", "bo", "rembo_4", "hesbo_2", "cmaes_lm", "bo_lm"}) {
    Valley valley;
    OptimiserOptions options = ManyEvaluations();
    options.budget = 29.0;
    options.jacobian_cost_units = 0.0;
    const OptimiserRun run = RunOptimiser(name, valley, options);
    EXPECT_EQ(run.spent, run.evaluations) << name;
    EXPECT_LE(run.spent, 29.0) << name;
    if (!IsRefined(name)) {
      EXPECT_EQ(run.spent, 29.0) << name;
    }
  }
}

// A refined method searches as the search alone does, with what the refinement leaves of the
// budget; this then lowers the cost within its rounds.
TEST(Optimiser, ARefinedMethodIsItsSearchAndThenLevenbergMarquardt) {
  OptimiserOptions options = ManyEvaluations();
  options.budget = 100.0;
  Valley valley;
  const OptimiserRun refined = RunOptimiser("cmaes_lm", valley, options);
  EXPECT_LE(refined.spent, 100.0);
  options.budget = 58.0;
  const OptimiserRun search = RunOptimiser("cmaes", valley, options);
  ASSERT_GT(refined.trace.size(), search.trace.size());
  for (std::size_t i = 0; i < search.trace.size(); ++i) {
    EXPECT_EQ(refined.trace[i].cost, search.trace[i].cost);
    EXPECT_EQ(refined.trace[i].spent, search.trace[i].spent);
  }
  EXPECT_GT(refined.trace[search.trace.size()].spent, search.spent + 1.0);
  EXPECT_LT(refined.cost, 1e-3 * search.cost);
  EXPECT_LE(refined.jacobians - search.jacobians, kRefiningRounds + 1);
}

// What a method spends outside the function is not among the function's seconds.
TEST(Optimiser, TimesTheFunctionApart) {
  Valley valley;
  OptimiserOptions options = EnoughEvaluations("bo");
  const OptimiserRun run = RunOptimiser("bo", valley, options);
  EXPECT_GT(run.function_seconds, 0.0);
  EXPECT_GE(run.function_seconds, run.jacobian_seconds);
  EXPECT_LT(run.function_seconds, 0.1 * run.seconds);
}

TEST(Optimiser, ASearchThatCannotRunIsAnInputError) {
  Valley valley;
  OptimiserOptions options = ManyEvaluations();
  options.search_command.back() = "missing.py";
  EXPECT_INPUT_ERROR(RunOptimiser("bo", valley, options), "expected numpy and scipy");
  options.search_command = {"/missing/python3"};
  EXPECT_INPUT_ERROR(RunOptimiser("bo", valley, options), "in /missing/python3");
}

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
  ResidualOptions options = test::CloseOutlineOptions();
  options.sigma_px = 0.5;
  DrapeFunction function(&backend, &parametrisation, observations, {rest}, options, 2.0);
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
  ResidualOptions options = test::CloseOutlineOptions();
  options.max_outline_change = 1.0;
  DrapeFunction function(&backend, &parametrisation, observations, {backend.model().RestState()},
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

// Any drape counts for a search; from its best point on, only those near the prediction.
TEST(DrapeFunction, FollowsTheBranchOfTheBestDrapeOnceItIsRefined) {
  test::FakeBackend backend;
  const TableParametrisation parametrisation(test::TestMaterial(), ParameterTying::kScales);
  const State rest = backend.model().RestState();
  std::vector<Observation> observations = {
      test::MakeObservation(backend.model().mesh, rest, 36, "flat")};
  ResidualOptions options = test::CloseOutlineOptions();
  options.max_outline_change = 1.0;
  DrapeFunction function(&backend, &parametrisation, observations, {rest}, options, 1.0, true);
  const Eigen::Vector2d far(2.0, 0.0);
  Eigen::VectorXd residual, again;
  RowMatrix jacobian;
  ASSERT_TRUE(function.Evaluate(Eigen::Vector2d::Zero(), &residual, &jacobian));
  EXPECT_TRUE(function.Evaluate(far, &again, nullptr));
  function.RefineFromBest();
  ASSERT_TRUE(function.Evaluate(Eigen::Vector2d::Zero(), &again, &jacobian));
  EXPECT_LT((again - residual).norm(), 1e-9);
  EXPECT_FALSE(function.Evaluate(far, &again, nullptr));
  EXPECT_EQ(function.cost_units(), 0.0);
}

TEST(DrapeFunction, SaysWhereThereIsNoDrape) {
  test::FakeBackend backend;
  backend.fails = [](double stretch, double) { return stretch > 0.5; };
  const TableParametrisation parametrisation(test::TestMaterial(), ParameterTying::kScales);
  std::vector<Observation> observations = {
      test::MakeObservation(backend.model().mesh, backend.model().RestState(), 36, "flat")};
  DrapeFunction function(&backend, &parametrisation, observations, {backend.model().RestState()},
                         test::CloseOutlineOptions(), 1.0);
  Eigen::VectorXd residual;
  EXPECT_TRUE(function.Evaluate(Eigen::Vector2d(0.4, 0.0), &residual, nullptr));
  EXPECT_FALSE(function.Evaluate(Eigen::Vector2d(0.6, 0.0), &residual, nullptr));
}

}  // namespace
}  // namespace drape
