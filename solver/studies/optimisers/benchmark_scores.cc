// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/benchmark_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/util/math/quantile.h"
#include "solver/forward/branch.h"

namespace drape {
namespace {

double CostGap(const OptimiserBenchmark& benchmark, int problem, double cost) {
  const double best = benchmark.Best(problem).run.cost, start = benchmark.StartCost(problem);
  return start > best ? std::min(1.0, (cost - best) / (start - best)) : 0.0;
}

// Adds a run to the sums of its method.
void AddRun(const OptimiserBenchmark& benchmark, int problem, const BenchmarkRecord& record,
            double branch_tolerance, MethodScore* score) {
  const BenchmarkRecord& best = benchmark.Best(problem);
  const double gap = CostGap(benchmark, problem, record.run.cost);
  score->solved_loose += gap <= kLooseTolerance;
  score->solved_tight += gap <= kTightTolerance;
  score->wins += record.run.cost <= 1.001 * best.run.cost;
  score->failed += record.run.failed;
  if (record.shape.size() == 0) return;
  score->largest_coupling = std::max(score->largest_coupling, record.coupling);
  score->mean_rms_px += record.rms_px;
  score->mean_settled_rms_px += record.settled_rms_px;
  score->best_branch += VertexDistance(record.shape, best.shape) <= branch_tolerance;
}

MethodScore ScoreMethod(const OptimiserBenchmark& benchmark, int method, double branch_tolerance) {
  MethodScore score{.method = benchmark.methods[method]};
  std::vector<double> gaps, seconds, own_seconds;
  double drapes = 0.0, evaluations = 0.0;
  for (int p = 0; p < benchmark.num_problems(); ++p)
    for (int s = 0; s < benchmark.num_seeds(); ++s) {
      const BenchmarkRecord& record = benchmark.Record(p, method, s);
      AddRun(benchmark, p, record, branch_tolerance, &score);
      gaps.push_back(CostGap(benchmark, p, record.run.cost));
      seconds.push_back(record.run.seconds);
      own_seconds.push_back(record.run.seconds - record.run.function_seconds);
      evaluations += record.run.evaluations + record.run.jacobians;
      drapes += record.shape.size() > 0;
    }
  for (double* share : {&score.solved_loose, &score.solved_tight, &score.wins, &score.best_branch})
    *share /= static_cast<double>(gaps.size());
  score.mean_rms_px /= std::max(1.0, drapes);
  score.mean_settled_rms_px /= std::max(1.0, drapes);
  score.failed /= std::max(1.0, evaluations);
  score.gap = ComputeQuartiles(gaps);
  score.median_seconds = ComputeQuartiles(seconds).median;
  score.median_own_seconds = ComputeQuartiles(own_seconds).median;
  return score;
}

// What each run spent until its cost was at most the target of its problem.
Eigen::MatrixXd SpentToReachTargets(const OptimiserBenchmark& benchmark,
                                    const std::vector<double>& targets, BudgetUnit unit) {
  const int seeds = benchmark.num_seeds();
  Eigen::MatrixXd spent(benchmark.num_problems() * seeds, benchmark.num_methods());
  for (int p = 0; p < benchmark.num_problems(); ++p)
    for (int s = 0; s < seeds; ++s)
      for (int m = 0; m < benchmark.num_methods(); ++m)
        spent(p * seeds + s, m) =
            SpentToReach(benchmark.Record(p, m, s).run.trace, targets[p], unit);
  return spent;
}

}  // namespace

Quartiles ComputeQuartiles(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  return {Quantile(values, 0.25), Quantile(values, 0.5), Quantile(values, 0.75)};
}

OptimiserBenchmark SelectProblems(const OptimiserBenchmark& benchmark, int parameters) {
  OptimiserBenchmark selected;
  selected.methods = benchmark.methods;
  for (int p = 0; p < benchmark.num_problems(); ++p) {
    if (benchmark.Record(p, 0, 0).parameters != parameters) continue;
    selected.problems.push_back(benchmark.problems[p]);
    for (int m = 0; m < benchmark.num_methods(); ++m) selected.runs.push_back(benchmark.Runs(p, m));
  }
  return selected;
}

std::vector<MethodScore> ScoreMethods(const OptimiserBenchmark& benchmark,
                                      double branch_tolerance) {
  std::vector<MethodScore> scores;
  for (int m = 0; m < benchmark.num_methods(); ++m)
    scores.push_back(ScoreMethod(benchmark, m, branch_tolerance));
  return scores;
}

Eigen::MatrixXd SpentToSolve(const OptimiserBenchmark& benchmark, double tolerance,
                             BudgetUnit unit) {
  std::vector<double> targets;
  for (int p = 0; p < benchmark.num_problems(); ++p)
    targets.push_back(SolvedBelow(benchmark.StartCost(p), benchmark.Best(p).run.cost, tolerance));
  return SpentToReachTargets(benchmark, targets, unit);
}

Eigen::MatrixXd SpentToReachLm(const OptimiserBenchmark& benchmark) {
  const auto lm = std::find(benchmark.methods.begin(), benchmark.methods.end(), "lm");
  if (lm == benchmark.methods.end()) return {};
  const int method = static_cast<int>(lm - benchmark.methods.begin());
  std::vector<double> targets;
  for (int p = 0; p < benchmark.num_problems(); ++p)
    targets.push_back(kReachedFactor * benchmark.Record(p, method, 0).run.cost);
  return SpentToReachTargets(benchmark, targets, BudgetUnit::kBudget);
}

double MeasuredJacobianCost(const OptimiserBenchmark& benchmark) {
  double jacobian_seconds = 0.0, seconds = 0.0, jacobians = 0.0, evaluations = 0.0;
  for (const std::vector<BenchmarkRecord>& all : benchmark.runs)
    for (const BenchmarkRecord& record : all) {
      if (record.run.jacobians == 0) continue;
      jacobian_seconds += record.run.jacobian_seconds;
      seconds += record.run.function_seconds - record.run.jacobian_seconds;
      jacobians += record.run.jacobians;
      evaluations += record.run.evaluations;
    }
  return jacobians == 0.0 ? 0.0 : (jacobian_seconds / jacobians) / (seconds / evaluations);
}

Quartiles GapsAt(const OptimiserBenchmark& benchmark, int method, double spent) {
  std::vector<double> gaps;
  for (int p = 0; p < benchmark.num_problems(); ++p)
    for (int s = 0; s < benchmark.num_seeds(); ++s) {
      double cost = std::numeric_limits<double>::infinity();
      for (const TracePoint& point : benchmark.Record(p, method, s).run.trace)
        if (point.spent <= spent) cost = point.cost;
      gaps.push_back(CostGap(benchmark, p, cost));
    }
  return ComputeQuartiles(gaps);
}

}  // namespace drape
