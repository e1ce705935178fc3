// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/studies/comparison/comparison_table.h"

namespace drape {
namespace {

struct ModelPoint {
  std::string model;
  double rollouts = 0.0, own = 0.0, held_out = 0.0;
  double error = 0.0;                     // standard error of the difference from the best
  bool chosen = false, compared = false;  // not compared: an experiment has no score
};

std::optional<double> ComputeMean(const ComparisonRow& row, const std::string& key) {
  const auto found = row.numbers.find(key);
  if (found == row.numbers.end()) return std::nullopt;
  return found->second.spread.mean;
}

std::vector<ModelPoint> MakePoints(const ComparisonTable& table) {
  std::vector<ModelPoint> points;
  for (const ComparisonRow& row : table.rows) {
    const auto rollouts = ComputeMean(row, "rollouts"), own = ComputeMean(row, "train_mse"),
               held_out = ComputeMean(row, "feature_energy");
    if (!rollouts || !own || !held_out) continue;
    ModelPoint point{row.model, *rollouts, *own, *held_out, 0.0, row.model == table.choice.chosen};
    for (const ScoreDifference& difference : table.choice.differences)
      if (difference.model == row.model) {
        point.error = difference.standard_error;
        point.compared = true;
      }
    points.push_back(point);
  }
  return points;
}

double ComputeHeight(std::size_t model) { return static_cast<double>(model + 1); }

// A row for each model, the simplest above.
ChartAxis ModelAxis(const std::vector<ModelPoint>& points, bool named) {
  ChartAxis axis{.range = {{static_cast<double>(points.size()) + 0.6, 0.4}}};
  axis.ticks.emplace();
  for (std::size_t i = 0; i < points.size(); ++i)
    axis.ticks->emplace_back(ComputeHeight(i), named ? points[i].model : "");
  return axis;
}

// The points of one look; `of` takes the number from the point.
template <class Of, class Keep>
ChartSeries SelectPoints(const std::vector<ModelPoint>& points, const Of& of, ChartSeries series,
                         const Keep& keep) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!keep(points[i])) continue;
    series.points.emplace_back(of(points[i]), ComputeHeight(i));
    if (series.mark == Mark::kErrorBars) series.values.push_back(points[i].error);
  }
  return series;
}

// left, right: shares of the picture.
template <class Of>
Chart MakePanel(const std::vector<ModelPoint>& points, double left, double right, const Of& of,
                Mark mark) {
  constexpr char kTeal[] = "#21918c", kRed[] = "#d62728";
  constexpr double kSize = 1.3;
  return {.x = {.room = 0.05, .tilt = -45},
          .y = ModelAxis(points, false),
          .series = {SelectPoints(points, of, {.mark = mark, .colour = kTeal, .size = kSize},
                                  [](const ModelPoint& p) { return p.compared && !p.chosen; }),
                     SelectPoints(points, of, {.mark = mark, .colour = kRed, .size = kSize},
                                  [](const ModelPoint& p) { return p.compared && p.chosen; }),
                     SelectPoints(points, of,
                                  {.title = "an experiment has no score: not compared",
                                   .mark = Mark::kPoints,
                                   .colour = kTeal,
                                   .symbol = Symbol::kRing,
                                   .size = kSize},
                                  [](const ModelPoint& p) { return !p.compared; })},
          .key = KeyPlace::kNone,
          .box = ChartBox{left, right, 0.21, 0.85}};
}

// Drapes of other samples, a circle: a dashed line each where it is not far off.
void AddTrivialLines(const ComparisonTable& table, const std::vector<ModelPoint>& points,
                     Chart* chart) {
  double most = 0.0;
  for (const ModelPoint& point : points) most = std::max(most, point.held_out + point.error);
  for (const ComparisonRow& row : table.rows) {
    const auto energy = ComputeMean(row, "feature_energy");
    if (!energy || ComputeMean(row, "rollouts") || *energy > 2 * most) continue;
    const auto [bottom, top] = *chart->y.range;
    chart->series.push_back({.title = row.model,
                             .points = {{*energy, bottom}, {*energy, top}},
                             .colour = "#555555",
                             .width = 1.0,
                             .dashed = true});
  }
}

Chart HeldOutPanel(const ComparisonTable& table, const std::vector<ModelPoint>& points) {
  Chart chart = MakePanel(
      points, 0.13, 0.42, [](const ModelPoint& point) { return point.held_out; }, Mark::kErrorBars);
  chart.title = "held-out drapes";
  chart.x.label = "energy score of the features";
  chart.y = ModelAxis(points, true);
  chart.key_at = Eigen::Vector2d(0.01, 0.07);
  AddTrivialLines(table, points, &chart);
  return chart;
}

}  // namespace

void RenderModelChart(const std::string& path, const ComparisonTable& table) {
  const std::vector<ModelPoint> points = MakePoints(table);
  if (points.empty()) return;
  Chart own = MakePanel(
      points, 0.45, 0.7, [](const ModelPoint& point) { return point.own; }, Mark::kPoints);
  own.title = "own silhouettes";
  own.x.label = "mean squared error of the image";
  Chart cost = MakePanel(
      points, 0.73, 0.98, [](const ModelPoint& point) { return point.rollouts; }, Mark::kPoints);
  cost.title = "cost of the fit";
  cost.x.label = "rollouts";
  cost.x.log = true;
  const Picture picture{
      .title = (table.fabric == 0 ? "All fabrics" : Format("Fabric %d", table.fabric)) +
               ": the simplest model within one standard error of the best is red",
      .width = 1100,
      .height = 520,
      .columns = 3,
      .charts = {HeldOutPanel(table, points), std::move(own), std::move(cost)}};
  WritePicture(path + ".png", picture);
  WritePicture(path + ".svg", picture);
}

}  // namespace drape
