// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/benchmark_scores.h"

#include <algorithm>
#include <limits>

#include "solver/forward/branch.h"

namespace drape {
namespace {

double CostGap(const OptimiserBenchmark& benchmark, int problem, double cost) {
  const double best = benchmark.Best(problem).run.cost, start = benchmark.StartCost(problem);
  return start > best ? std::min(1.0, (cost - best) / (start - best)) : 0.0;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

MethodScore ScoreMethod(const OptimiserBenchmark& benchmark, int method, double branch_tolerance) {
  MethodScore score{.method = benchmark.methods[method]};
  std::vector<double> gaps, seconds;
  double drapes = 0.0, evaluations = 0.0;
  for (int p = 0; p < benchmark.num_problems(); ++p) {
    const BenchmarkRecord& record = benchmark.Record(p, method);
    const BenchmarkRecord& best = benchmark.Best(p);
    gaps.push_back(CostGap(benchmark, p, record.run.cost));
    seconds.push_back(record.run.seconds);
    score.solved_loose += gaps.back() <= kLooseTolerance;
    score.solved_tight += gaps.back() <= kTightTolerance;
    score.wins += record.run.cost <= 1.001 * best.run.cost;
    score.failed += record.run.failed;
    evaluations += record.run.evaluations + record.run.jacobians;
    if (record.shape.size() == 0) continue;
    ++drapes;
    score.largest_coupling = std::max(score.largest_coupling, record.coupling);
    score.mean_rms_px += record.rms_px;
    score.mean_settled_rms_px += record.settled_rms_px;
    score.best_branch += VertexDistance(record.shape, best.shape) <= branch_tolerance;
  }
  for (double* share : {&score.solved_loose, &score.solved_tight, &score.wins, &score.best_branch})
    *share /= benchmark.num_problems();
  score.mean_rms_px /= std::max(1.0, drapes);
  score.mean_settled_rms_px /= std::max(1.0, drapes);
  score.failed /= std::max(1.0, evaluations);
  score.median_gap = Median(gaps);
  score.median_seconds = Median(seconds);
  return score;
}

}  // namespace

std::vector<MethodScore> ScoreMethods(const OptimiserBenchmark& benchmark,
                                      double branch_tolerance) {
  std::vector<MethodScore> scores;
  for (int m = 0; m < benchmark.num_methods(); ++m)
    scores.push_back(ScoreMethod(benchmark, m, branch_tolerance));
  return scores;
}

Eigen::MatrixXd SpentToSolve(const OptimiserBenchmark& benchmark, double tolerance,
                             BudgetUnit unit) {
  Eigen::MatrixXd spent(benchmark.num_problems(), benchmark.num_methods());
  for (int p = 0; p < benchmark.num_problems(); ++p) {
    const double target =
        SolvedBelow(benchmark.StartCost(p), benchmark.Best(p).run.cost, tolerance);
    for (int m = 0; m < benchmark.num_methods(); ++m)
      spent(p, m) = SpentToReach(benchmark.Record(p, m).run.trace, target, unit);
  }
  return spent;
}

double MeasuredJacobianCost(const OptimiserBenchmark& benchmark) {
  double jacobian_seconds = 0.0, seconds = 0.0, jacobians = 0.0, evaluations = 0.0;
  for (const BenchmarkRecord& record : benchmark.records) {
    if (record.run.jacobians == 0) continue;
    jacobian_seconds += record.run.jacobian_seconds;
    seconds += record.run.seconds - record.run.jacobian_seconds;
    jacobians += record.run.jacobians;
    evaluations += record.run.evaluations;
  }
  return jacobians == 0.0 ? 0.0 : (jacobian_seconds / jacobians) / (seconds / evaluations);
}

double MedianGapAt(const OptimiserBenchmark& benchmark, int method, double spent) {
  std::vector<double> gaps;
  for (int p = 0; p < benchmark.num_problems(); ++p) {
    double cost = std::numeric_limits<double>::infinity();
    for (const TracePoint& point : benchmark.Record(p, method).run.trace)
      if (point.spent <= spent) cost = point.cost;
    gaps.push_back(CostGap(benchmark, p, cost));
  }
  return Median(gaps);
}

}  // namespace drape
