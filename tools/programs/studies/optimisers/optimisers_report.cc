// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/optimisers/optimisers_report.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/studies/optimisers/methods/optimiser.h"
#include "tools/cli/provenance.h"
#include "tools/programs/studies/optimisers/optimisers_charts.h"

namespace drape {
namespace {

// "median [lower quartile, upper quartile]"
std::string Range(const Quartiles& values, const char* format) {
  std::string text = Format(format, values.median);
  if (values.low == values.high) return text;
  return text + " [" + Format(format, values.low) + ", " + Format(format, values.high) + "]";
}

// Of each method the gap at each budget, and what it spent to reach Levenberg–Marquardt's cost. A
// refined method has its result at the end only.
TextTable BudgetTable(const OptimiserBenchmarkOptions& options,
                      const OptimiserBenchmark& benchmark) {
  const std::vector<double> budgets = ReportedBudgets(options);
  const Eigen::MatrixXd reached = SpentToReachLm(benchmark);
  std::vector<std::string> columns = {"method"};
  for (const double budget : budgets) columns.push_back(Format("gap at %g", budget));
  if (reached.size() > 0) {
    columns.push_back(Format("reaches %g × lm", kReachedFactor));
    columns.emplace_back("rollouts to it");
  }
  TextTable table(columns);
  for (int m = 0; m < benchmark.num_methods(); ++m) {
    std::vector<std::string> row = {benchmark.methods[m]};
    const bool refined = !FindOptimiser(row.front()).search.empty();
    for (const double budget : budgets)
      row.push_back(refined && budget < options.optimiser.budget
                        ? "–"
                        : Range(GapsAt(benchmark, m, budget), "%.3f"));
    if (reached.size() > 0) {
      const Eigen::VectorXd column = reached.col(m);
      row.push_back(Format("%.2f", ProfileAt(column, std::numeric_limits<double>::max())));
      row.push_back(Range(ComputeQuartiles({column.begin(), column.end()}), "%.0f"));
    }
    table.Add(row);
  }
  return table;
}

std::string BudgetTables(const OptimiserBenchmarkOptions& options,
                         const OptimiserBenchmark& benchmark) {
  std::string text;
  for (const int parameters : options.parameters) {
    const OptimiserBenchmark selected = SelectProblems(benchmark, parameters);
    if (selected.problems.empty()) continue;
    text +=
        Format("%d numbers:\n\n", parameters) + BudgetTable(options, selected).Markdown() + "\n";
  }
  return text;
}

TextTable ProblemTable(const OptimiserBenchmark& benchmark) {
  std::vector<std::string> columns = {"problem", "start"};
  columns.insert(columns.end(), benchmark.methods.begin(), benchmark.methods.end());
  TextTable table(columns);
  for (int p = 0; p < benchmark.num_problems(); ++p) {
    std::vector<std::string> row = {benchmark.problems[p], Format("%.4g", benchmark.StartCost(p))};
    for (int m = 0; m < benchmark.num_methods(); ++m) {
      std::vector<double> costs, rms;
      bool best = false;
      for (const BenchmarkRecord& record : benchmark.Runs(p, m)) {
        costs.push_back(record.run.cost);
        rms.push_back(record.rms_px);
        best = best || &record == &benchmark.Best(p);
      }
      const std::string cost = Range(ComputeQuartiles(costs), "%.4g");
      row.push_back((best ? "**" + cost + "**" : cost) +
                    Format(" (%.2f px)", ComputeQuartiles(rms).median));
    }
    table.Add(row);
  }
  return table;
}

std::string TraceCsv(const OptimiserBenchmark& benchmark) {
  std::string text = "problem,method,seed,spent_rollouts,cpu_s,cost\n";
  for (const std::vector<BenchmarkRecord>& all : benchmark.runs)
    for (const BenchmarkRecord& record : all)
      for (const TracePoint& point : record.run.trace)
        text += record.problem + "," + record.run.method +
                Format(",%d,%.6g,%.6g,%.9g\n", record.seed, point.spent, point.seconds, point.cost);
  return text;
}

nlohmann::json ToJson(const Quartiles& values) {
  return {{"low", values.low}, {"median", values.median}, {"high", values.high}};
}

nlohmann::json ToJson(const BenchmarkRecord& record) {
  return {{"problem", record.problem},
          {"method", record.run.method},
          {"seed", record.seed},
          {"cost", record.shape.size() > 0 ? nlohmann::json(record.run.cost) : nlohmann::json()},
          {"end", record.run.end},
          {"spent", record.run.spent},
          {"cpu_s", record.run.seconds},
          {"own_cpu_s", record.run.seconds - record.run.function_seconds},
          {"failed", record.run.failed},
          {"rms_px", record.rms_px},
          {"settled_rms_px", record.settled_rms_px},
          {"drift_m", record.drift},
          {"coupling", record.coupling},
          {"lowest_eigenvalue", record.stiffness}};
}

nlohmann::json MakeSummary(const OptimiserBenchmarkOptions& options,
                           const OptimiserBenchmark& benchmark) {
  nlohmann::json summary = {{"outcome", benchmark.cancelled ? "cancelled" : "done"},
                            {"problems", benchmark.problems},
                            {"notes", benchmark.notes},
                            {"budget_rollouts", options.optimiser.budget},
                            {"jacobian_cost_units", options.optimiser.jacobian_cost_units},
                            {"jacobian_cost_measured", MeasuredJacobianCost(benchmark)}};
  const Eigen::MatrixXd reached = SpentToReachLm(benchmark);
  for (const MethodScore& score : ScoreMethods(benchmark, options.branch_tolerance)) {
    const int m = static_cast<int>(summary["methods"].size());
    nlohmann::json method = {{"name", score.method},
                             {"solved_at_0.1", score.solved_loose},
                             {"solved_at_0.01", score.solved_tight},
                             {"wins", score.wins},
                             {"best_branch", score.best_branch},
                             {"gap", ToJson(score.gap)},
                             {"mean_rms_px", score.mean_rms_px},
                             {"mean_settled_rms_px", score.mean_settled_rms_px},
                             {"largest_coupling", score.largest_coupling},
                             {"failed_share", score.failed},
                             {"median_cpu_s", score.median_seconds},
                             {"median_own_cpu_s", score.median_own_seconds}};
    for (const double budget : ReportedBudgets(options))
      method["gaps"].push_back(
          {{"rollouts", budget}, {"gap", ToJson(GapsAt(benchmark, m, budget))}});
    if (reached.size() > 0)
      method["reaches_lm"] = ProfileAt(reached.col(m), std::numeric_limits<double>::max());
    summary["methods"].push_back(std::move(method));
  }
  for (const std::vector<BenchmarkRecord>& all : benchmark.runs)
    for (const BenchmarkRecord& record : all) summary["runs"].push_back(ToJson(record));
  return summary;
}

}  // namespace

TextTable MakeMethodTable(const OptimiserBenchmark& benchmark, double branch_tolerance) {
  TextTable table({"method", "within 10 %", "within 1 %", "best", "best branch", "gap", "rms [px]",
                   "settled rms [px]", "c12²/(c11·c22)", "failed", "CPU s", "own CPU s"});
  for (const MethodScore& score : ScoreMethods(benchmark, branch_tolerance))
    table.Add({score.method, Format("%.2f", score.solved_loose), Format("%.2f", score.solved_tight),
               Format("%.2f", score.wins), Format("%.2f", score.best_branch),
               Range(score.gap, "%.4f"), Format("%.2f", score.mean_rms_px),
               Format("%.2f", score.mean_settled_rms_px), Format("%.3f", score.largest_coupling),
               Format("%.2f", score.failed), Format("%.1f", score.median_seconds),
               Format("%.1f", score.median_own_seconds)});
  return table;
}

void WriteBenchmarkReport(const OptimiserBenchmarkOptions& options, const OutputFolder& out,
                          OptimiserBenchmark* benchmark) {
  const std::string missing =
      TryPictures([&] { WriteBenchmarkPictures(options, *benchmark, out); });
  if (!missing.empty()) benchmark->notes.push_back(missing.substr(0, missing.find('\n')));
  std::string report =
      MakeMethodTable(*benchmark, options.branch_tolerance).Markdown() +
      Format(
          "\nA Jacobian cost %.2f rollouts of CPU time beside its own; "
          "it was paid with %g.\n\n",
          MeasuredJacobianCost(*benchmark), options.optimiser.jacobian_cost_units) +
      BudgetTables(options, *benchmark) + ProblemTable(*benchmark).Markdown();
  for (const std::string& note : benchmark->notes) report += "\n" + note + "\n";
  WriteFileAtomically(out.Staged("report.md"), report);
  WriteFileAtomically(out.Staged("traces.csv"), TraceCsv(*benchmark));
  WriteWithProvenance(out.Staged("summary.json"), MakeSummary(options, *benchmark));
}

}  // namespace drape
