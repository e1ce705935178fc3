// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/optimisers/optimisers_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"

namespace drape {
namespace {

Chart ConvergenceChart(const OptimiserBenchmark& benchmark, double budget) {
  constexpr int kPoints = 150;
  constexpr double kLeastGap = 1e-2;
  Chart chart{.title = "Median over " + std::to_string(benchmark.num_problems()) + " problems",
              .x = {.label = "spent [rollouts]", .log = true},
              .y = {.label = "(cost − best) / (start − best)", .log = true, .range = {{1e-2, 1.5}}},
              .key = KeyPlace::kOutside};
  for (int m = 0; m < benchmark.num_methods(); ++m) {
    ChartSeries line{.title = benchmark.methods[m]};
    for (int i = 0; i <= kPoints; ++i) {
      const double spent = std::pow(budget, double(i) / kPoints);
      line.points.emplace_back(spent, std::max(kLeastGap, MedianGapAt(benchmark, m, spent)));
    }
    chart.series.push_back(std::move(line));
  }
  return chart;
}

Chart ProfileChart(const OptimiserBenchmark& benchmark, double tolerance, BudgetUnit unit) {
  constexpr double kLargestFactor = 100.0;
  const bool budget = unit == BudgetUnit::kBudget;
  Chart chart{.title = Format("Solved: %g of the way to the best", 1.0 - tolerance),
              .x = {.label = budget ? "rollouts by those of the quickest method"
                                    : "CPU seconds by those of the quickest method",
                    .log = true},
              .y = {.label = "share of the problems", .range = {{0.0, 1.02}}},
              .key = KeyPlace::kOutside};
  const Eigen::MatrixXd ratios = PerformanceRatios(SpentToSolve(benchmark, tolerance, unit));
  for (int m = 0; m < benchmark.num_methods(); ++m) {
    ChartSeries line{.title = benchmark.methods[m], .mark = Mark::kSteps};
    for (const ProfileStep& step : ProfileSteps(ratios.col(m)))
      if (step.factor <= kLargestFactor) line.points.emplace_back(step.factor, step.share);
    line.points.emplace_back(kLargestFactor, ProfileAt(ratios.col(m), kLargestFactor));
    chart.series.push_back(std::move(line));
  }
  return chart;
}

Chart BranchChart(const OptimiserBenchmark& benchmark, double branch_tolerance) {
  Chart chart{.title = "Ends on the branch of the best method",
              .x = {.tilt = -30},
              .y = {.label = "share of the problems", .range = {{0.0, 1.1}}}};
  ChartSeries bars{.mark = Mark::kBars, .colour = "#0072b2"};
  chart.x.ticks.emplace();
  for (const MethodScore& score : ScoreMethods(benchmark, branch_tolerance)) {
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

TextTable ProblemTable(const OptimiserBenchmark& benchmark) {
  std::vector<std::string> columns = {"problem", "start"};
  columns.insert(columns.end(), benchmark.methods.begin(), benchmark.methods.end());
  TextTable table(columns);
  for (int p = 0; p < benchmark.num_problems(); ++p) {
    std::vector<std::string> row = {benchmark.problems[p], Format("%.4g", benchmark.StartCost(p))};
    for (int m = 0; m < benchmark.num_methods(); ++m) {
      const BenchmarkRecord& record = benchmark.Record(p, m);
      const bool best = &record == &benchmark.Best(p);
      row.push_back(
          Format(best ? "**%.4g** (%.2f px)" : "%.4g (%.2f px)", record.run.cost, record.rms_px));
    }
    table.Add(row);
  }
  return table;
}

std::string TraceCsv(const OptimiserBenchmark& benchmark) {
  std::string text = "problem,method,spent_rollouts,cpu_s,cost\n";
  for (const BenchmarkRecord& record : benchmark.records)
    for (const TracePoint& point : record.run.trace)
      text += record.problem + "," + record.run.method +
              Format(",%.6g,%.6g,%.9g\n", point.spent, point.seconds, point.cost);
  return text;
}

void WritePictures(const OptimiserBenchmarkOptions& options, const OptimiserBenchmark& benchmark,
                   const OutputFolder& out) {
  WritePicture(out.Staged("convergence.png"),
               {.charts = {ConvergenceChart(benchmark, options.optimiser.budget)}});
  WritePicture(out.Staged("profiles.png"),
               {.charts = {ProfileChart(benchmark, kLooseTolerance, BudgetUnit::kBudget),
                           ProfileChart(benchmark, kLooseTolerance, BudgetUnit::kSeconds),
                           ProfileChart(benchmark, kTightTolerance, BudgetUnit::kBudget),
                           ProfileChart(benchmark, kTightTolerance, BudgetUnit::kSeconds)}});
  WritePicture(
      out.Staged("branches.png"),
      {.width = 820, .height = 420, .charts = {BranchChart(benchmark, options.branch_tolerance)}});
}

nlohmann::json MakeSummary(const OptimiserBenchmarkOptions& options,
                           const OptimiserBenchmark& benchmark) {
  nlohmann::json summary = {{"outcome", benchmark.cancelled ? "cancelled" : "done"},
                            {"problems", benchmark.problems},
                            {"notes", benchmark.notes},
                            {"budget_rollouts", options.optimiser.budget},
                            {"jacobian_cost_units", options.optimiser.jacobian_cost_units},
                            {"jacobian_cost_measured", MeasuredJacobianCost(benchmark)}};
  for (const MethodScore& score : ScoreMethods(benchmark, options.branch_tolerance))
    summary["methods"].push_back({{"name", score.method},
                                  {"solved_at_0.1", score.solved_loose},
                                  {"solved_at_0.01", score.solved_tight},
                                  {"wins", score.wins},
                                  {"best_branch", score.best_branch},
                                  {"median_gap", score.median_gap},
                                  {"mean_rms_px", score.mean_rms_px},
                                  {"mean_settled_rms_px", score.mean_settled_rms_px},
                                  {"largest_coupling", score.largest_coupling},
                                  {"failed_share", score.failed},
                                  {"median_cpu_s", score.median_seconds}});
  for (const BenchmarkRecord& record : benchmark.records)
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
         {"drift_m", record.drift},
         {"coupling", record.coupling},
         {"lowest_eigenvalue", record.stiffness}});
  return summary;
}

}  // namespace

TextTable MakeMethodTable(const OptimiserBenchmark& benchmark, double branch_tolerance) {
  TextTable table({"method", "within 10 %", "within 1 %", "best", "best branch", "median gap",
                   "rms [px]", "settled rms [px]", "c12^2/(c11 c22)", "failed", "CPU s"});
  for (const MethodScore& score : ScoreMethods(benchmark, branch_tolerance))
    table.Add({score.method, Format("%.2f", score.solved_loose), Format("%.2f", score.solved_tight),
               Format("%.2f", score.wins), Format("%.2f", score.best_branch),
               Format("%.4f", score.median_gap), Format("%.2f", score.mean_rms_px),
               Format("%.2f", score.mean_settled_rms_px), Format("%.3f", score.largest_coupling),
               Format("%.2f", score.failed), Format("%.1f", score.median_seconds)});
  return table;
}

void WriteBenchmarkReport(const OptimiserBenchmarkOptions& options, const OutputFolder& out,
                          OptimiserBenchmark* benchmark) {
  const std::string missing = TryPictures([&] { WritePictures(options, *benchmark, out); });
  if (!missing.empty()) benchmark->notes.push_back(missing.substr(0, missing.find('\n')));
  std::string report =
      MakeMethodTable(*benchmark, options.branch_tolerance).Markdown() +
      Format(
          "\nA Jacobian cost %.2f rollouts of CPU time beside its own; "
          "it was paid with %g.\n\n",
          MeasuredJacobianCost(*benchmark), options.optimiser.jacobian_cost_units) +
      ProblemTable(*benchmark).Markdown();
  for (const std::string& note : benchmark->notes) report += "\n" + note + "\n";
  WriteFileAtomically(out.Staged("report.md"), report);
  WriteFileAtomically(out.Staged("traces.csv"), TraceCsv(*benchmark));
  WriteFileAtomically(out.Staged("summary.json"), MakeSummary(options, *benchmark).dump(1) + "\n");
}

}  // namespace drape
