// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/job/plot/label_places.h"
#include "solver/studies/comparison/comparison_table.h"

namespace drape {
namespace {

struct ModelPoint {
  std::string model;
  double rollouts = 0.0, held_out = 0.0;
  std::optional<double> own;  // of models that are fitted to silhouettes
  double parameters = 0.0, seconds = 0.0;
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
    const auto rollouts = ComputeMean(row, "rollouts"),
               held_out = ComputeMean(row, "feature_energy");
    if (!rollouts || !held_out) continue;
    ModelPoint point{.model = row.model,
                     .rollouts = *rollouts,
                     .held_out = *held_out,
                     .own = ComputeMean(row, "train_mse"),
                     .parameters = ComputeMean(row, "parameters").value_or(0.0),
                     .seconds = ComputeMean(row, "fit_seconds").value_or(0.0),
                     .chosen = row.model == table.choice.chosen};
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

// The energy of a predictor without a model; none of `normal`, whose label would cover others.
std::optional<double> TrivialEnergy(const ComparisonRow& row) {
  if (ComputeMean(row, "rollouts") || row.model == kNormal) return std::nullopt;
  return ComputeMean(row, "feature_energy");
}

// Drapes of other samples, a circle: a dashed line each where it is not far off.
void AddTrivialLines(const ComparisonTable& table, const std::vector<ModelPoint>& points,
                     Chart* chart) {
  double most = 0.0;
  for (const ModelPoint& point : points) most = std::max(most, point.held_out + point.error);
  for (const ComparisonRow& row : table.rows) {
    const auto energy = TrivialEnergy(row);
    if (!energy || *energy > 2 * most) continue;
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

// What the held-out errors are compared with: the drapes of other samples, and a circle.
struct Bound {
  double energy;
  std::string text;
};
std::vector<Bound> FindBounds(const ComparisonTable& table) {
  std::vector<Bound> bounds;
  for (const ComparisonRow& row : table.rows) {
    const auto energy = TrivialEnergy(row);
    if (!energy || *energy <= 0.0) continue;
    bounds.push_back({*energy, row.model == kOtherSamples
                                   ? "drapes of the training samples themselves"
                               : row.model == kCircle ? "a circle of their mean area"
                                                      : row.model});
  }
  return bounds;
}

// Held-out error against one cost of the models, named beside their points; `of` takes it.
template <class Of>
Chart CostPanel(std::vector<ModelPoint> points, const std::vector<Bound>& bounds,
                const std::string& cost, const Of& of) {
  constexpr char kBlue[] = "#0072b2", kGrey[] = "#555555";
  constexpr double kFits = 1e-3;  // room of an axis that its lines fill
  constexpr double kRoom = 0.12, kLeastExtent = 0.1;
  const Eigen::Vector2d kPanel(460, 360);  // [px], about
  Chart chart{.x = {.label = cost, .log = true, .room = kFits},
              .y = {.label = "energy score of held-out drapes, lower is better",
                    .log = true,
                    .room = kRoom},
              .key = KeyPlace::kNone};
  std::erase_if(points, [&](const ModelPoint& point) { return !(of(point) > 0.0); });
  if (points.empty()) return chart;
  std::sort(points.begin(), points.end(),
            [&](const ModelPoint& a, const ModelPoint& b) { return of(a) < of(b); });
  ChartSeries models{.mark = Mark::kPoints, .colour = kBlue, .size = 1.5};
  for (const ModelPoint& point : points) {
    models.points.emplace_back(of(point), point.held_out);
    chart.labels.push_back(
        {.text = point.model, .at = models.points.back().array().log(), .font_size = 10});
  }
  const double left = of(points.front()) / 2.0, right = of(points.back()) * 6.0;
  double best = points.front().held_out, most = best;
  for (const ModelPoint& point : points) {
    best = std::min(best, point.held_out);
    most = std::max(most, point.held_out);
  }
  double least = best;
  for (const Bound& bound : bounds) {
    least = std::min(least, bound.energy);
    most = std::max(most, bound.energy);
  }
  const Eigen::Vector2d extent(std::log(right / left), (1 + 2 * kRoom) * std::log(most / least));
  PlaceAround(kPanel.cwiseQuotient(extent.cwiseMax(kLeastExtent)), &chart.labels);
  for (ChartLabel& label : chart.labels) label.at = label.at.array().exp();
  for (const Bound& bound : bounds) {
    chart.series.push_back({.points = {{left, bound.energy}, {right, bound.energy}},
                            .colour = kGrey,
                            .width = 1.5,
                            .dashed = true});
    chart.labels.push_back({.text = bound.text,
                            .at = {left, bound.energy},
                            .font_size = 10,
                            .offset = {0.8, bound.energy < best ? -0.6 : 0.6}});
  }
  chart.series.push_back(std::move(models));
  return chart;
}

}  // namespace

void RenderHeldOutChart(const std::string& path, const ComparisonTable& table) {
  const std::vector<ModelPoint> points = MakePoints(table);
  if (points.empty()) return;
  const std::vector<Bound> bounds = FindBounds(table);
  const Picture picture{
      .title = "How well models predict drapes of other samples",
      .width = 1100,
      .height = 460,
      .charts = {CostPanel(points, bounds, "free numbers of the model",
                           [](const ModelPoint& point) { return point.parameters; }),
                 CostPanel(points, bounds, "time of the fit [s]",
                           [](const ModelPoint& point) { return point.seconds; })}};
  WritePicture(path + ".png", picture);
  WritePicture(path + ".svg", picture);
}

void RenderModelChart(const std::string& path, const ComparisonTable& table) {
  std::vector<ModelPoint> points = MakePoints(table);
  std::erase_if(points, [](const ModelPoint& point) { return !point.own; });
  if (points.empty()) return;
  Chart own = MakePanel(
      points, 0.45, 0.7, [](const ModelPoint& point) { return *point.own; }, Mark::kPoints);
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
