// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/optimisers/optimisers_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/forward/branch.h"
#include "solver/job/plot/chart.h"

namespace drape {
namespace {

int NumMethods(const OptimiserBenchmark& race) { return static_cast<int>(race.methods.size()); }
int NumProblems(const OptimiserBenchmark& race) { return static_cast<int>(race.problems.size()); }

const BenchmarkRecord& FindRecord(const OptimiserBenchmark& race, int problem, int method) {
  return race.records[problem * NumMethods(race) + method];
}

// The run of least cost on a problem.
const BenchmarkRecord& FindBest(const OptimiserBenchmark& race, int problem) {
  int best = 0;
  for (int m = 1; m < NumMethods(race); ++m)
    if (FindRecord(race, problem, m).run.cost < FindRecord(race, problem, best).run.cost) best = m;
  return FindRecord(race, problem, best);
}

// The common start: the first cost of any run.
double StartCost(const OptimiserBenchmark& race, int problem) {
  for (int m = 0; m < NumMethods(race); ++m)
    if (!FindRecord(race, problem, m).run.trace.empty())
      return FindRecord(race, problem, m).run.trace.front().cost;
  return std::numeric_limits<double>::infinity();
}

double CostGap(const OptimiserBenchmark& race, int problem, double cost) {
  const double best = FindBest(race, problem).run.cost, start = StartCost(race, problem);
  return start > best ? std::min(1.0, (cost - best) / (start - best)) : 0.0;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

// The median gap over the problems at a moment of the budget.
double MedianGapAt(const OptimiserBenchmark& race, int method, double spent) {
  std::vector<double> gaps;
  for (int p = 0; p < NumProblems(race); ++p) {
    double cost = std::numeric_limits<double>::infinity();
    for (const TracePoint& point : FindRecord(race, p, method).run.trace)
      if (point.spent <= spent) cost = point.cost;
    gaps.push_back(CostGap(race, p, cost));
  }
  return Median(gaps);
}

Chart ConvergenceChart(const OptimiserBenchmark& race, double budget) {
  constexpr int kPoints = 150;
  constexpr double kLeastGap = 1e-2;
  Chart chart{.title = "Median over " + std::to_string(NumProblems(race)) + " problems",
              .x = {.label = "spent [rollouts]", .log = true},
              .y = {.label = "(cost − best) / (start − best)", .log = true, .range = {{1e-2, 1.5}}},
              .key = KeyPlace::kOutside};
  for (int m = 0; m < NumMethods(race); ++m) {
    ChartSeries line{.title = race.methods[m]};
    for (int i = 0; i <= kPoints; ++i) {
      const double spent = std::pow(budget, double(i) / kPoints);
      line.points.emplace_back(spent, std::max(kLeastGap, MedianGapAt(race, m, spent)));
    }
    chart.series.push_back(std::move(line));
  }
  return chart;
}

Chart ProfileChart(const OptimiserBenchmark& race, double tolerance, BudgetUnit currency) {
  constexpr double kLargestFactor = 100.0;
  const bool budget = currency == BudgetUnit::kBudget;
  Chart chart{.title = Format("Solved: %g of the way to the best", 1.0 - tolerance),
              .x = {.label = budget ? "rollouts by those of the quickest method"
                                    : "CPU seconds by those of the quickest method",
                    .log = true},
              .y = {.label = "share of the problems", .range = {{0.0, 1.02}}},
              .key = KeyPlace::kOutside};
  const Eigen::MatrixXd ratios = PerformanceRatios(SpentToSolve(race, tolerance, currency));
  for (int m = 0; m < NumMethods(race); ++m) {
    ChartSeries line{.title = race.methods[m], .mark = Mark::kSteps};
    for (const ProfileStep& step : ProfileSteps(ratios.col(m)))
      if (step.factor <= kLargestFactor) line.points.emplace_back(step.factor, step.share);
    line.points.emplace_back(kLargestFactor, ProfileAt(ratios.col(m), kLargestFactor));
    chart.series.push_back(std::move(line));
  }
  return chart;
}

Chart BranchChart(const OptimiserBenchmark& race, double branch_tolerance) {
  Chart chart{.title = "Ends on the branch of the best method",
              .x = {.tilt = -30},
              .y = {.label = "share of the problems", .range = {{0.0, 1.1}}}};
  ChartSeries bars{.mark = Mark::kBars, .colour = "#0072b2"};
  chart.x.ticks.emplace();
  for (const MethodScore& score : ScoreMethods(race, branch_tolerance)) {
    const double x = static_cast<double>(bars.points.size());
    bars.points.emplace_back(x, score.best_branch);
    chart.x.ticks->emplace_back(x, score.method);
    chart.labels.push_back({.text = Format("%.2f", score.best_branch),
                            .at = {x, score.best_branch + 0.04},
                            .align = ChartLabel::Align::kCentre,
                            .font_size = 11});
  }
  chart.x.range = {-0.6, static_cast<double>(bars.points.size()) - 0.4};
  chart.series.push_back(std::move(bars));
  return chart;
}

MethodScore ScoreMethod(const OptimiserBenchmark& race, int method, double branch_tolerance) {
  MethodScore score{.method = race.methods[method]};
  std::vector<double> gaps, seconds;
  double drapes = 0.0, evaluations = 0.0;
  for (int p = 0; p < NumProblems(race); ++p) {
    const BenchmarkRecord& record = FindRecord(race, p, method);
    const BenchmarkRecord& best = FindBest(race, p);
    gaps.push_back(CostGap(race, p, record.run.cost));
    seconds.push_back(record.run.seconds);
    score.solved_loose += gaps.back() <= kLooseTolerance;
    score.solved_tight += gaps.back() <= kTightTolerance;
    score.wins += record.run.cost <= 1.001 * best.run.cost;
    score.failed += record.run.failed;
    evaluations += record.run.evaluations + record.run.jacobians;
    if (record.shape.size() == 0) continue;
    ++drapes;
    score.mean_rms_px += record.rms_px;
    score.mean_settled_rms_px += record.settled_rms_px;
    score.best_branch += VertexDistance(record.shape, best.shape) <= branch_tolerance;
  }
  for (double* share : {&score.solved_loose, &score.solved_tight, &score.wins, &score.best_branch})
    *share /= NumProblems(race);
  score.mean_rms_px /= std::max(1.0, drapes);
  score.mean_settled_rms_px /= std::max(1.0, drapes);
  score.failed /= std::max(1.0, evaluations);
  score.median_gap = Median(gaps);
  score.median_seconds = Median(seconds);
  return score;
}

std::string ProblemTable(const OptimiserBenchmark& race) {
  std::string text = "| problem | start |", rule = "|---|---|";
  for (const std::string& method : race.methods) {
    text += " " + method + " |";
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (int p = 0; p < NumProblems(race); ++p) {
    text += "| " + race.problems[p] + Format(" | %.4g |", StartCost(race, p));
    for (int m = 0; m < NumMethods(race); ++m) {
      const BenchmarkRecord& record = FindRecord(race, p, m);
      const bool best = &record == &FindBest(race, p);
      text += Format(best ? " **%.4g** (%.2f px) |" : " %.4g (%.2f px) |", record.run.cost,
                     record.rms_px);
    }
    text += "\n";
  }
  return text;
}

std::string TraceCsv(const OptimiserBenchmark& race) {
  std::string text = "problem,method,spent_rollouts,cpu_s,cost\n";
  for (const BenchmarkRecord& record : race.records)
    for (const TracePoint& point : record.run.trace)
      text += record.problem + "," + record.run.method +
              Format(",%.6g,%.6g,%.9g\n", point.spent, point.seconds, point.cost);
  return text;
}

nlohmann::json MakeSummary(const OptimiserBenchmarkOptions& options,
                           const OptimiserBenchmark& race) {
  nlohmann::json summary = {{"outcome", race.cancelled ? "cancelled" : "done"},
                            {"problems", race.problems},
                            {"notes", race.notes},
                            {"budget_rollouts", options.race.budget},
                            {"jacobian_cost_units", options.race.jacobian_cost_units},
                            {"jacobian_cost_measured", MeasuredJacobianCost(race)}};
  for (const MethodScore& score : ScoreMethods(race, options.branch_tolerance))
    summary["methods"].push_back({{"name", score.method},
                                  {"solved_at_0.1", score.solved_loose},
                                  {"solved_at_0.01", score.solved_tight},
                                  {"wins", score.wins},
                                  {"best_branch", score.best_branch},
                                  {"median_gap", score.median_gap},
                                  {"mean_rms_px", score.mean_rms_px},
                                  {"mean_settled_rms_px", score.mean_settled_rms_px},
                                  {"failed_share", score.failed},
                                  {"median_cpu_s", score.median_seconds}});
  for (const BenchmarkRecord& record : race.records)
    summary["runs"].push_back(
        {{"problem", record.problem},
         {"method", record.run.method},
         {"cost", record.shape.size() > 0 ? nlohmann::json(record.run.cost) : nlohmann::json()},
         {"end", record.run.end},
         {"spent", record.run.spent},
         {"cpu_s", record.run.seconds},
         {"failed", record.run.failed},
         {"rms_px", record.rms_px},
         {"settled_rms_px", record.settled_rms_px},
         {"moved_m", record.moved},
         {"lowest_eigenvalue", record.stiffness}});
  return summary;
}

}  // namespace

std::vector<MethodScore> ScoreMethods(const OptimiserBenchmark& race, double branch_tolerance) {
  std::vector<MethodScore> scores;
  for (int m = 0; m < NumMethods(race); ++m)
    scores.push_back(ScoreMethod(race, m, branch_tolerance));
  return scores;
}

Eigen::MatrixXd SpentToSolve(const OptimiserBenchmark& race, double tolerance,
                             BudgetUnit currency) {
  Eigen::MatrixXd spent(NumProblems(race), NumMethods(race));
  for (int p = 0; p < NumProblems(race); ++p) {
    const double target = SolvedBelow(StartCost(race, p), FindBest(race, p).run.cost, tolerance);
    for (int m = 0; m < NumMethods(race); ++m)
      spent(p, m) = SpentToReach(FindRecord(race, p, m).run.trace, target, currency);
  }
  return spent;
}

double MeasuredJacobianCost(const OptimiserBenchmark& race) {
  double jacobian_seconds = 0.0, seconds = 0.0, jacobians = 0.0, evaluations = 0.0;
  for (const BenchmarkRecord& record : race.records) {
    if (record.run.jacobians == 0) continue;
    jacobian_seconds += record.run.jacobian_seconds;
    seconds += record.run.seconds - record.run.jacobian_seconds;
    jacobians += record.run.jacobians;
    evaluations += record.run.evaluations;
  }
  return jacobians == 0.0 ? 0.0 : (jacobian_seconds / jacobians) / (seconds / evaluations);
}

std::string MethodTableText(const OptimiserBenchmark& race, double branch_tolerance) {
  std::string text =
      "| method | within 10 % | within 1 % | best | best branch | median gap | rms [px] | settled "
      "[px] | failed | CPU s |\n|---|---|---|---|---|---|---|---|---|---|\n";
  for (const MethodScore& score : ScoreMethods(race, branch_tolerance))
    text += Format("| %s | %.2f | %.2f | %.2f | %.2f | %.4f | %.2f | %.2f | %.2f | %.1f |\n",
                   score.method.c_str(), score.solved_loose, score.solved_tight, score.wins,
                   score.best_branch, score.median_gap, score.mean_rms_px,
                   score.mean_settled_rms_px, score.failed, score.median_seconds);
  return text;
}

void WriteBenchmarkReport(const OptimiserBenchmarkOptions& options, const OptimiserBenchmark& race,
                          const OutputFolder& out) {
  const std::string table = MethodTableText(race, options.branch_tolerance);
  WriteFileAtomically(out.Staged("report.md"),
                      table +
                          Format("\nA Jacobian cost %.2f rollouts of CPU time beside its own; "
                                 "it was paid with %g.\n\n",
                                 MeasuredJacobianCost(race), options.race.jacobian_cost_units) +
                          ProblemTable(race));
  WriteFileAtomically(out.Staged("traces.csv"), TraceCsv(race));
  WriteFileAtomically(out.Staged("summary.json"), MakeSummary(options, race).dump(1) + "\n");
  WritePicture(out.Staged("convergence.png"),
               {.charts = {ConvergenceChart(race, options.race.budget)}});
  WritePicture(out.Staged("profiles.png"),
               {.charts = {ProfileChart(race, kLooseTolerance, BudgetUnit::kBudget),
                           ProfileChart(race, kLooseTolerance, BudgetUnit::kSeconds),
                           ProfileChart(race, kTightTolerance, BudgetUnit::kBudget),
                           ProfileChart(race, kTightTolerance, BudgetUnit::kSeconds)}});
  WritePicture(
      out.Staged("branches.png"),
      {.width = 820, .height = 420, .charts = {BranchChart(race, options.branch_tolerance)}});
}

}  // namespace drape
