// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/optimisers/optimisers_charts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/studies/optimisers/methods/optimiser.h"

namespace drape {
namespace {

// Methods that are shown in one chart, by their positions.
struct MethodGroup {
  std::string title;  // ", alone"; empty where there is one group
  std::vector<int> methods;
};

std::vector<MethodGroup> GroupMethods(const OptimiserBenchmark& benchmark) {
  MethodGroup alone{", alone", {}}, refined{", refined by Levenberg–Marquardt", {}};
  for (int m = 0; m < benchmark.num_methods(); ++m) {
    const std::string& name = benchmark.methods[m];
    const bool is_refined = !FindOptimiser(name).search.empty();
    if (!is_refined) alone.methods.push_back(m);
    if (is_refined || name == "lm") refined.methods.push_back(m);
  }
  const bool any_refined = alone.methods.size() < benchmark.methods.size();
  if (any_refined) return {alone, refined};
  return {{"", alone.methods}};
}

// One colour per family, darker with more numbers of the embedding; a refined method looks like its
// search.
ChartSeries StyledLine(const std::string& method) {
  static const std::map<std::string, std::string> colours = {
      {"cmaes", "#984ea3"},   {"bo", "#009e73"},      {"rembo_2", "#9ecae1"},
      {"rembo_4", "#3182bd"}, {"rembo_8", "#08306b"}, {"hesbo_2", "#fdbe85"},
      {"hesbo_4", "#fd8d3c"}, {"hesbo_8", "#a63603"}, {"rembo_ucb_4", "#3182bd"}};
  ChartSeries line{.title = method};
  if (method == "lm") {
    line.colour = "#000000";
    line.width = 3.0;
    return line;
  }
  const std::string& search = FindOptimiser(method).search;
  const std::string& name = search.empty() ? method : search;
  if (const auto found = colours.find(name); found != colours.end()) line.colour = found->second;
  line.dashed = name == "rembo_ucb_4";
  return line;
}

std::string CountProblems(const OptimiserBenchmark& benchmark) {
  const int problems = benchmark.num_problems();
  std::string text = std::to_string(problems) + (problems == 1 ? " problem" : " problems");
  if (benchmark.num_seeds() > 1) text += " × " + std::to_string(benchmark.num_seeds()) + " seeds";
  return text;
}

Chart ConvergenceChart(const OptimiserBenchmark& benchmark, const MethodGroup& group,
                       double budget) {
  constexpr int kPoints = 150;
  constexpr double kLeastGap = 1e-2;
  Chart chart{.title = "Median over " + CountProblems(benchmark) + group.title,
              .x = {.label = "spent [rollouts]", .log = true},
              .y = {.label = "(cost − best) / (start − best)", .log = true, .range = {{1e-2, 1.5}}},
              .key = KeyPlace::kOutside};
  for (const int m : group.methods) {
    ChartSeries line = StyledLine(benchmark.methods[m]);
    for (int i = 0; i <= kPoints; ++i) {
      const double spent = std::pow(budget, double(i) / kPoints);
      line.points.emplace_back(spent, std::max(kLeastGap, GapsAt(benchmark, m, spent).median));
    }
    chart.series.push_back(std::move(line));
  }
  return chart;
}

// Staircases of the columns of a matrix of shape [runs, methods].
void AddStaircases(const OptimiserBenchmark& benchmark, const MethodGroup& group,
                   const Eigen::MatrixXd& values, double largest, Chart* chart) {
  for (const int m : group.methods) {
    ChartSeries line = StyledLine(benchmark.methods[m]);
    line.mark = Mark::kSteps;
    for (const ProfileStep& step : ProfileSteps(values.col(m)))
      if (step.factor <= largest) line.points.emplace_back(step.factor, step.share);
    line.points.emplace_back(largest, ProfileAt(values.col(m), largest));
    chart->series.push_back(std::move(line));
  }
}

std::string SolvedTitle(double tolerance, const MethodGroup& group) {
  return Format("Problems solved to %g %% of the way to the best", 100 * (1.0 - tolerance)) +
         group.title;
}

Chart ProfileChart(const OptimiserBenchmark& benchmark, const MethodGroup& group, double tolerance,
                   BudgetUnit unit) {
  constexpr double kLargestFactor = 100.0;
  const bool budget = unit == BudgetUnit::kBudget;
  Chart chart{.title = SolvedTitle(tolerance, group),
              .x = {.label = budget ? "rollouts by those of the quickest method"
                                    : "CPU seconds by those of the quickest method",
                    .log = true},
              .y = {.label = "share of the problems", .range = {{0.0, 1.02}}},
              .key = KeyPlace::kOutside};
  AddStaircases(benchmark, group, PerformanceRatios(SpentToSolve(benchmark, tolerance, unit)),
                kLargestFactor, &chart);
  return chart;
}

Chart DataProfileChart(const OptimiserBenchmark& benchmark, const MethodGroup& group,
                       const std::string& problems, double tolerance, double budget) {
  Chart chart{.title = problems +
                       Format(", %g %% of the way to the best", 100 * (1.0 - tolerance)) +
                       group.title,
              .x = {.label = "spent [rollouts]", .log = true, .range = {{1.0, budget}}},
              .y = {.label = "share of the problems", .range = {{0.0, 1.02}}},
              .key = KeyPlace::kOutside};
  AddStaircases(benchmark, group, SpentToSolve(benchmark, tolerance, BudgetUnit::kBudget), budget,
                &chart);
  return chart;
}

// Rows of methods, the first on top; each budget has a symbol with a line between quartiles. A
// refined method has its result at the last one only.
Chart QuartileChart(const OptimiserBenchmark& benchmark, const std::string& problems,
                    const std::vector<double>& budgets) {
  constexpr double kLeastGap = 1e-3, kOffset = 0.22;
  constexpr Symbol kSymbols[] = {Symbol::kDisc, Symbol::kSquare, Symbol::kTriangle,
                                 Symbol::kDiamond};
  const char* const colours[] = {"#56b4e9", "#e69f00", "#000000", "#cc79a7"};
  const int methods = benchmark.num_methods();
  Chart chart{
      .title = problems + ": median and quartiles, " + CountProblems(benchmark),
      .x = {.label = "(cost − best) / (start − best)", .log = true, .range = {{kLeastGap, 1.2}}},
      .y = {.range = {{-0.7, methods - 0.3}}},
      .key = KeyPlace::kOutside};
  chart.y.ticks.emplace();
  for (int m = 0; m < methods; ++m)
    chart.y.ticks->emplace_back(methods - 1 - m, benchmark.methods[m]);
  const int count = static_cast<int>(budgets.size());
  for (int c = 0; c < count; ++c) {
    const std::string colour = colours[c % std::size(colours)];
    ChartSeries medians{.title = Format("%g rollouts", budgets[c]),
                        .mark = Mark::kPoints,
                        .colour = colour,
                        .symbol = kSymbols[c % std::size(kSymbols)],
                        .size = 1.2};
    ChartSeries bars{.colour = colour};
    for (int m = 0; m < methods; ++m) {
      if (c + 1 < count && !FindOptimiser(benchmark.methods[m]).search.empty()) continue;
      const Quartiles gap = GapsAt(benchmark, m, budgets[c]);
      const double y = methods - 1 - m + kOffset * (0.5 * (count - 1) - c);
      const auto clipped = [&](double x) { return std::max(kLeastGap, x); };
      medians.points.emplace_back(clipped(gap.median), y);
      bars.points.emplace_back(clipped(gap.low), y);
      bars.points.emplace_back(clipped(gap.high), y);
      bars.points.emplace_back(std::nan(""), y);
    }
    chart.series.push_back(std::move(bars));
    chart.series.push_back(std::move(medians));
  }
  return chart;
}

// With room for the names of methods, which gnuplot does not reserve. height: of the picture [px].
void PlaceSideBySide(double height, std::vector<Chart>* charts) {
  const double count = static_cast<double>(charts->size());
  for (std::size_t i = 0; i < charts->size(); ++i) {
    const double left = static_cast<double>(i);
    (*charts)[i].box =
        ChartBox{(left + 0.18) / count, (left + 0.8) / count, 70.0 / height, 1.0 - 40.0 / height};
  }
}

Chart BranchChart(const OptimiserBenchmark& benchmark, double branch_tolerance) {
  Chart chart{.title = "Ends on the branch of the best run",
              .x = {.tilt = -30},
              .y = {.label = "share of the problems [%]", .range = {{0.0, 110.0}}},
              .box = ChartBox{0.08, 0.92, 0.27, 0.9}};  // with room for the names of methods
  ChartSeries bars{.mark = Mark::kBars, .colour = "#0072b2"};
  chart.x.ticks.emplace();
  for (const MethodScore& score : ScoreMethods(benchmark, branch_tolerance)) {
    const double x = static_cast<double>(bars.points.size()), percent = 100 * score.best_branch;
    bars.points.emplace_back(x, percent);
    chart.x.ticks->emplace_back(x, score.method);
    chart.labels.push_back({.text = Format("%.0f", percent),
                            .at = {x, percent + 4.0},
                            .align = ChartLabel::Align::kCentre,
                            .font_size = 11});
  }
  chart.x.range = {-0.6, static_cast<double>(bars.points.size()) - 0.4};
  chart.series.push_back(std::move(bars));
  return chart;
}

std::vector<Chart> ProfileCharts(const OptimiserBenchmark& benchmark) {
  std::vector<Chart> charts;
  for (const double tolerance : {kLooseTolerance, kTightTolerance})
    for (const MethodGroup& group : GroupMethods(benchmark))
      for (const BudgetUnit unit : {BudgetUnit::kBudget, BudgetUnit::kSeconds})
        charts.push_back(ProfileChart(benchmark, group, tolerance, unit));
  return charts;
}

}  // namespace

void WriteBenchmarkPictures(const OptimiserBenchmarkOptions& options,
                            const OptimiserBenchmark& benchmark, const OutputFolder& out) {
  const double budget = options.optimiser.budget;
  const std::vector<MethodGroup> groups = GroupMethods(benchmark);
  std::vector<Chart> convergence, data_profiles, quartiles;
  for (const MethodGroup& group : groups)
    convergence.push_back(ConvergenceChart(benchmark, group, budget));
  for (const int parameters : options.parameters) {
    const OptimiserBenchmark selected = SelectProblems(benchmark, parameters);
    if (selected.problems.empty()) continue;
    const std::string problems = std::to_string(parameters) + " numbers";
    for (const double tolerance : {kHalfTolerance, kLooseTolerance})
      data_profiles.push_back(
          DataProfileChart(selected, groups.front(), problems, tolerance, budget));
    if (groups.size() > 1)
      data_profiles.push_back(
          DataProfileChart(selected, groups.back(), problems, kLooseTolerance, budget));
    quartiles.push_back(QuartileChart(selected, problems, ReportedBudgets(options)));
  }
  const int methods = benchmark.num_methods();
  const int height = 140 + 44 * methods;
  PlaceSideBySide(height, &quartiles);
  WritePicture(out.Staged("convergence.png"), {.charts = convergence});
  WritePicture(out.Staged("profiles.png"), {.charts = ProfileCharts(benchmark)});
  WritePicture(out.Staged("data_profiles.png"),
               {.columns = groups.size() > 1 ? 3 : 2, .charts = data_profiles});
  WritePicture(out.Staged("quartiles.png"), {.width = 720 * static_cast<int>(quartiles.size()),
                                             .height = 140 + 44 * methods,
                                             .columns = static_cast<int>(quartiles.size()),
                                             .charts = quartiles});
  WritePicture(out.Staged("branches.png"),
               {.width = std::max(820, 160 + 50 * methods),
                .height = 440,
                .charts = {BranchChart(benchmark, options.branch_tolerance)}});
}

}  // namespace drape
