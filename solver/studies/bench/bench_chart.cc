// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "physics/util/math/statistics.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/studies/bench/pareto.h"

namespace drape {
namespace {

constexpr Symbol kSymbols[] = {Symbol::kDisc,    Symbol::kSquare,       Symbol::kTriangle,
                               Symbol::kDiamond, Symbol::kTriangleDown, Symbol::kPentagon};
constexpr double kRoom = 0.12;  // of an axis, on each side of the data

Symbol ChooseSymbol(std::size_t series) { return kSymbols[series % std::size(kSymbols)]; }

void WritePictures(const std::string& path, Picture picture) {
  picture.width = 1100;
  picture.height = 640;
  WritePicture(path + ".png", picture);
  WritePicture(path + ".svg", picture);
}

std::vector<ChartPoint> Usable(const FrontChart& chart) {
  std::vector<ChartPoint> points;
  for (const ChartPoint& point : chart.points)
    if (point.cost > 0 && point.error > 0 && std::isfinite(point.cost * point.error))
      points.push_back(point);
  return points;
}

std::vector<ChartPoint> AccuracyFront(const std::vector<ChartPoint>& points) {
  std::vector<CostAndError> candidates;
  std::vector<ChartPoint> eligible, front;
  for (const ChartPoint& point : points)
    if (point.excluded.empty()) eligible.push_back(point);
  for (const ChartPoint& point : eligible) candidates.push_back({point.cost, point.error});
  for (const int i : ParetoFront(candidates)) front.push_back(eligible[i]);
  return front;
}

using Ticks = std::vector<std::pair<double, std::string>>;

Ticks VertexTicks(const std::vector<double>& vertices) {
  Ticks ticks;
  for (const double value : std::set<double>(vertices.begin(), vertices.end()))
    ticks.emplace_back(value, Format("%.9g", value));
  return ticks;
}

// Numbers of the front's points beside them; those of points close together in one text.
void AddNumberLabels(const std::vector<ChartPoint>& front, Chart* chart) {
  constexpr double kNear = 0.07;  // decades
  for (std::size_t i = 0; i < front.size();) {
    std::string text = std::to_string(i + 1);
    std::size_t next = i + 1;
    for (; next < front.size() && std::log10(front[next].cost / front[i].cost) < kNear &&
           std::log10(front[i].error / front[next].error) < kNear;
         ++next)
      text += "," + std::to_string(next + 1);
    chart->labels.push_back({.text = text,
                             .at = {front[i].cost, front[i].error},
                             .align = ChartLabel::Align::kRight,
                             .font_size = 10,
                             .offset = {-0.7, -0.7}});
    i = next;
  }
}

void AddFrontList(const std::vector<ChartPoint>& front, Chart* chart) {
  constexpr double kLeft = 0.665, kTop = 0.86, kLine = 0.036;
  constexpr std::size_t kMost = 15;
  const auto add = [&](const std::string& text, double height, int font_size) {
    chart->labels.push_back(
        {.text = text, .at = {kLeft, height}, .in_picture = true, .font_size = font_size});
  };
  add("Pareto front: seconds, error, setting", kTop + 0.045, 10);
  const std::size_t shown = std::min(front.size(), kMost);
  for (std::size_t i = 0; i < shown; ++i)
    add(Format("%zu  %.3g  %.3g  ", i + 1, front[i].cost, front[i].error) + front[i].label,
        kTop - kLine * static_cast<double>(i), 9);
  if (front.size() > shown)
    add("… all in bench.json", kTop - kLine * static_cast<double>(shown), 9);
}

template <class Keep>
ChartSeries SelectPoints(const std::vector<ChartPoint>& points, ChartSeries series,
                         const Keep& keep) {
  const bool has_colour = series.colour.empty();
  for (const ChartPoint& point : points) {
    if (!keep(point)) continue;
    series.points.emplace_back(point.cost, point.error);
    if (has_colour) series.values.push_back(point.vertices);
  }
  return series;
}

std::vector<ChartSeries> FrontSeries(const FrontChart& chart, const std::vector<ChartPoint>& points,
                                     const std::vector<ChartPoint>& front) {
  std::vector<ChartSeries> series;
  std::set<std::string> reasons;
  for (const ChartPoint& point : points)
    if (!point.excluded.empty()) reasons.insert(point.excluded);
  for (const std::string& reason : reasons)
    series.push_back(SelectPoints(points,
                                  {.title = reason,
                                   .mark = Mark::kPoints,
                                   .colour = "#aaaaaa",
                                   .symbol = series.empty() ? Symbol::kRing : Symbol::kCross},
                                  [&](const ChartPoint& p) { return p.excluded == reason; }));
  series.push_back(SelectPoints(front, {.title = "Pareto front", .colour = "#d62728"},
                                [](const ChartPoint&) { return true; }));
  for (std::size_t s = 0; s < chart.series.size(); ++s)
    series.push_back(SelectPoints(
        points,
        {.title = chart.series[s], .mark = Mark::kPoints, .symbol = ChooseSymbol(s), .size = 1.5},
        [&](const ChartPoint& p) {
          return p.excluded.empty() && p.series == static_cast<int>(s);
        }));
  return series;
}

// A level line over the width of the points.
ChartSeries ReferenceLine(double error, const std::vector<ChartPoint>& points) {
  const auto [least, most] = std::minmax_element(
      points.begin(), points.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  return {.title = "error of the reference, estimated",
          .points = {{least->cost, error}, {most->cost, error}},
          .colour = "#555555",
          .width = 1.0,
          .dashed = true};
}

// One of the two panels: `of` takes the seconds or the megabytes of a series.
template <class Of>
Chart GrowthPanel(const std::vector<GrowthSeries>& series, const std::string& label, const Of& of) {
  Chart chart{.x = {.label = "vertices", .log = true, .room = kRoom},
              .y = {.label = label, .log = true, .room = kRoom},
              .key = KeyPlace::kTopLeft};
  std::vector<double> vertices;
  for (const GrowthSeries& one : series) {
    const std::vector<double>& y = of(one);
    ChartSeries line{.title = one.name + Format(": V^%.2f", FitPowerLaw(one.vertices, y)->exponent),
                     .mark = Mark::kLinePoints,
                     .symbol = ChooseSymbol(chart.series.size()),
                     .size = 1.3};
    for (std::size_t i = 0; i < y.size(); ++i) line.points.emplace_back(one.vertices[i], y[i]);
    vertices.insert(vertices.end(), one.vertices.begin(), one.vertices.end());
    chart.series.push_back(std::move(line));
  }
  chart.x.ticks = VertexTicks(vertices);
  return chart;
}

}  // namespace

void RenderFrontChart(const std::string& path, const FrontChart& front_chart) {
  const std::vector<ChartPoint> points = Usable(front_chart);
  const std::vector<ChartPoint> front = AccuracyFront(points);
  if (front.empty()) return;
  Chart chart{.x = {.label = front_chart.cost_name, .log = true, .room = kRoom},
              .y = {.label = front_chart.error_name, .log = true, .room = kRoom},
              .colour = {.label = "vertices", .log = true},
              .series = FrontSeries(front_chart, points, front),
              .key_at = Eigen::Vector2d(0.66, 0.24),
              .box = ChartBox{0.07, 0.55, 0.10, 0.92}};
  std::vector<double> vertices;
  for (const ChartPoint& point : points) vertices.push_back(point.vertices);
  chart.colour.ticks = VertexTicks(vertices);
  if (front_chart.reference_error > 0)
    chart.series.push_back(ReferenceLine(front_chart.reference_error, points));
  AddNumberLabels(front, &chart);
  AddFrontList(front, &chart);
  WritePictures(path, {.title = front_chart.title, .charts = {std::move(chart)}});
}

void RenderCodesChart(const std::string& path, const std::string& cost_name,
                      const std::vector<CodeSeries>& codes) {
  // Standard deviation between the samples of a fabric, of the mean of the captures of one face,
  // pooled over the five published fabrics: .023 of the drape coefficient.
  constexpr double kSamplesMm = 1.28;
  Chart chart{.x = {.label = cost_name, .log = true, .room = kRoom},
              .y = {.label = "error of the mean radius [mm], 1 mm is 1.7 points of DC",
                    .log = true,
                    .room = kRoom},
              .key = KeyPlace::kBottomRight};
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const CodeSeries& code : codes) {
    ChartSeries line{.title = code.name,
                     .mark = Mark::kLinePoints,
                     .symbol = ChooseSymbol(chart.series.size()),
                     .size = 1.5};
    for (std::size_t i = 0; i < code.seconds.size(); ++i) {
      line.points.emplace_back(code.seconds[i], code.radius_mm[i]);
      chart.labels.push_back({.text = Format("%.0f", code.vertices[i]),
                              .at = line.points.back(),
                              .font_size = 8,
                              .offset = {0.6, 0.5}});
      least = std::min(least, code.seconds[i]);
      most = std::max(most, code.seconds[i]);
    }
    chart.series.push_back(std::move(line));
  }
  chart.series.push_back({.points = {{least, kSamplesMm}, {most, kSamplesMm}},
                          .colour = "#555555",
                          .width = 1.5,
                          .dashed = true});
  chart.labels.push_back({.text = "scatter between samples of a fabric",
                          .at = {least, kSamplesMm},
                          .font_size = 10,
                          .offset = {0.0, 0.6}});
  Picture picture{.title = "Error of a drape against its time; numbers are vertices",
                  .charts = {std::move(chart)}};
  WritePictures(path, std::move(picture));
}

void RenderGrowthChart(const std::string& path, const std::string& title,
                       const std::string& cost_name, const std::vector<GrowthSeries>& series) {
  if (series.empty()) return;
  const auto seconds = [](const GrowthSeries& one) -> const auto& { return one.seconds; };
  const auto megabytes = [](const GrowthSeries& one) -> const auto& { return one.megabytes; };
  WritePictures(path, {.title = title,
                       .charts = {GrowthPanel(series, cost_name, seconds),
                                  GrowthPanel(series, "peak memory [MB]", megabytes)}});
}

}  // namespace drape
