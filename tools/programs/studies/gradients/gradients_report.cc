// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/gradients/gradients_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "tools/cli/provenance.h"

namespace drape {
namespace {

nlohmann::json NumberOrNull(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

nlohmann::json ToJson(const GradientError& error) {
  return {{"step", error.step}, {"size_m", error.size}, {"error", NumberOrNull(error.error)}};
}

nlohmann::json ToJson(const FollowedBranch& branch) {
  nlohmann::json json = {{"seed", branch.seed}, {"status", ToString(branch.path.status)}};
  for (const ContinuationPoint& point : branch.path.points)
    json["points"].push_back({{"s", point.s},
                              {"speed_m", point.speed},
                              {"lowest_eigenvalue", NumberOrNull(point.stiffness)}});
  if (!branch.approach) return json;
  const FoldApproach& approach = *branch.approach;
  if (approach.speed_by_distance)
    json["exponent_by_distance"] = approach.speed_by_distance->exponent;
  if (approach.speed_by_stiffness)
    json["exponent_by_eigenvalue"] = approach.speed_by_stiffness->exponent;
  return json;
}

nlohmann::json MakeSummary(const GradientStudy& study) {
  nlohmann::json summary = {{"outcome", study.cancelled ? "cancelled" : "done"}};
  for (const GradientSweep& sweep : study.sweeps) {
    nlohmann::json errors;
    for (const GradientError& error : sweep.errors) errors.push_back(ToJson(error));
    summary["differences"].push_back({{"of", sweep.name}, {"errors", errors}});
  }
  for (const HorizonSeries& series : study.horizons) {
    nlohmann::json errors;
    for (const GradientError& error : series.errors) errors.push_back(ToJson(error));
    summary["horizons"].push_back(
        {{"law", series.law}, {"h_s", series.h}, {"steps", series.horizons}, {"errors", errors}});
  }
  for (const FollowedBranch& branch : study.branches) summary["branches"].push_back(ToJson(branch));
  return summary;
}

Chart DifferencesChart(const GradientStudy& study) {
  Chart chart{.title = "Central differences against the tangent",
              .x = {.label = "step of the difference [log units]", .log = true},
              .y = {.label = "relative error", .log = true},
              .key = KeyPlace::kTop};
  for (const GradientSweep& sweep : study.sweeps) {
    ChartSeries line{.title = sweep.name, .mark = Mark::kLinePoints, .size = 0.6};
    for (const GradientError& error : sweep.errors)
      line.points.emplace_back(error.step, error.error);
    chart.series.push_back(std::move(line));
  }
  return chart;
}

Chart HorizonChart(const GradientStudy& study, bool of_error) {
  Chart chart{
      .title = of_error ? "Error of differences" : "Size of the gradient",
      .x = {.label = "simulated time [s]", .log = true},
      .y = {.label = of_error ? "relative error" : "|∂x/∂s|, root mean square [m]", .log = true},
      .key = of_error ? KeyPlace::kNone : KeyPlace::kBottomRight};  // the colours are those beside
  for (const HorizonSeries& series : study.horizons) {
    ChartSeries line{.title = series.law + Format(", h = %g s", series.h),
                     .mark = Mark::kLinePoints,
                     .size = 0.6};
    for (std::size_t i = 0; i < series.errors.size(); ++i)
      line.points.emplace_back(series.h * series.horizons[i],
                               of_error ? series.errors[i].error : series.errors[i].size);
    chart.series.push_back(std::move(line));
  }
  return chart;
}

Chart FoldChart(const GradientStudy& study, bool by_distance) {
  Chart chart{.title = "Towards the end of a branch",
              .x = {.label = by_distance ? "distance s* − s to the end [log units of bend]"
                                         : "lowest eigenvalue of K by M [1/s²]",
                    .log = true},
              .y = {.label = "|∂x/∂s|, root mean square [m]", .log = true},
              .key = KeyPlace::kTopRight};
  for (const FollowedBranch& branch : study.branches) {
    if (!branch.approach) continue;
    const FoldApproach& approach = *branch.approach;
    const auto& law = by_distance ? approach.speed_by_distance : approach.speed_by_stiffness;
    if (!law) continue;
    ChartSeries line{.title = Format("start %d, slope %.2f", branch.seed, law->exponent),
                     .mark = Mark::kLinePoints,
                     .size = 0.6};
    for (std::size_t i = 0; i < approach.speed.size(); ++i)
      line.points.emplace_back(by_distance ? approach.distance[i] : approach.stiffness[i],
                               approach.speed[i]);
    chart.series.push_back(std::move(line));
  }
  return chart;
}

TextTable DifferencesTable(const GradientStudy& study) {
  std::vector<std::string> columns = {"difference step"};
  for (const GradientSweep& sweep : study.sweeps) columns.push_back(sweep.name);
  TextTable table(columns);
  if (study.sweeps.empty()) return table;
  for (std::size_t i = 0; i < study.sweeps.front().errors.size(); ++i) {
    std::vector<std::string> row = {Format("%.0e", study.sweeps.front().errors[i].step)};
    for (const GradientSweep& sweep : study.sweeps)
      row.push_back(i < sweep.errors.size() ? Format("%.1e", sweep.errors[i].error) : "–");
    table.Add(row);
  }
  return table;
}

TextTable HorizonTable(const GradientStudy& study) {
  TextTable table({"law", "h [s]", "steps", "size of the gradient [m]", "error"});
  for (const HorizonSeries& series : study.horizons)
    for (std::size_t i = 0; i < series.errors.size(); ++i)
      table.Add({series.law, Format("%g", series.h), std::to_string(series.horizons[i]),
                 Format("%.2g", series.errors[i].size), Format("%.0e", series.errors[i].error)});
  return table;
}

TextTable BranchTable(const GradientStudy& study) {
  TextTable table({"start", "end", "at s", "lowest eigenvalue [1/s²]", "speed [m]",
                   "exponent by distance", "by eigenvalue"});
  for (const FollowedBranch& branch : study.branches) {
    const ContinuationResult& path = branch.path;
    std::vector<std::string> row = {std::to_string(branch.seed), ToString(path.status)};
    if (!path.points.empty()) {
      const ContinuationPoint &first = path.points.front(), &last = path.points.back();
      row.push_back(Format("%.5f", last.s));
      row.push_back(Format("%.3g → %.3g", first.stiffness, last.stiffness));
      row.push_back(Format("%.3g → %.3g", first.speed, last.speed));
      const auto& approach = branch.approach;
      const bool fitted = approach && approach->speed_by_distance && approach->speed_by_stiffness;
      row.push_back(fitted ? Format("%.2f", approach->speed_by_distance->exponent) : "–");
      row.push_back(fitted ? Format("%.2f", approach->speed_by_stiffness->exponent) : "–");
    }
    table.Add(row);
  }
  return table;
}

}  // namespace

std::vector<TextTable> MakeGradientTables(const GradientStudy& study) {
  return {DifferencesTable(study), HorizonTable(study), BranchTable(study)};
}

void WriteGradientReport(const OutputFolder& out, GradientStudy* study) {
  study->note = TryPictures([&] {
    WritePicture(out.Staged("differences.png"), {.charts = {DifferencesChart(*study)}});
    WritePicture(out.Staged("horizons.png"),
                 {.charts = {HorizonChart(*study, false), HorizonChart(*study, true)}});
    WritePicture(out.Staged("fold.png"),
                 {.charts = {FoldChart(*study, true), FoldChart(*study, false)}});
  });
  std::string report;
  for (const TextTable& table : MakeGradientTables(*study)) {
    if (!report.empty()) report += '\n';
    report += table.Markdown();
  }
  if (!study->note.empty()) report += '\n' + study->note;
  WriteFileAtomically(out.Staged("report.md"), report);
  WriteWithProvenance(out.Staged("summary.json"), MakeSummary(*study));
}

}  // namespace drape
