// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/studies/stability/stability_map.h"

namespace drape {
namespace {

// In the order of StabilityOutcome: greens for what came to rest at its place or will, warm colours
// for wrong answers, dark ones for none.
constexpr const char* kColours[kStabilityOutcomes] = {"#1a9850", "#a6d96a", "#fee08b", "#f46d43",
                                                      "#a50026", "#762a83", "#4d4d4d"};

// Squares have unit size, so positions between values go by the logarithm of these, or evenly where
// a value is zero.
double Position(const std::vector<double>& values, double value) {
  const auto scale = [&](double v) { return values.front() > 0.0 ? std::log(v) : v; };
  const std::size_t above = std::clamp<std::size_t>(
      std::upper_bound(values.begin(), values.end(), value) - values.begin(), 1, values.size() - 1);
  const double low = scale(values[above - 1]), high = scale(values[above]);
  return static_cast<double>(above) - 1.0 + (scale(value) - low) / (high - low);
}

ChartAxis MakeAxis(const StabilityMap& map, int k) {
  constexpr std::size_t kMostTicks = 15;
  const std::vector<double>& values = map.values[k];
  const std::size_t every = (values.size() + kMostTicks - 1) / kMostTicks;
  ChartAxis axis{.label = map.axis[k]->label,
                 .range = {{-0.5, static_cast<double>(values.size()) - 0.5}},
                 .tilt = k == 0 ? -45 : 0};
  axis.ticks.emplace();
  for (std::size_t i = 0; i < values.size(); i += every)
    axis.ticks->emplace_back(static_cast<double>(i), Format("%.4g", values[i]));
  return axis;
}

ChartSeries MakeSquares(const StabilityMap& map, const std::vector<int>& outcomes, int outcome) {
  const int across = static_cast<int>(map.values[0].size());
  ChartSeries squares{.title = ToString(static_cast<StabilityOutcome>(outcome)),
                      .mark = Mark::kSquares,
                      .colour = kColours[outcome]};
  for (int n = 0; n < static_cast<int>(outcomes.size()); ++n)
    if (outcomes[n] == outcome) squares.points.emplace_back(n % across, n / across);
  return squares;
}

// What is set besides the axes, from the name.
std::string MakeTitle(const StabilityMap& map) {
  std::string title = map.name;
  std::replace(title.begin(), title.end(), '-', ' ');
  return title;
}

}  // namespace

void RenderStabilityMap(const std::string& path, const StabilityMap& map,
                        const std::vector<int>& outcomes, const StabilityLine& line) {
  CHECK_EQ(outcomes.size(), map.values[0].size() * map.values[1].size());
  Chart chart{.title = MakeTitle(map),
              .x = MakeAxis(map, 0),
              .y = MakeAxis(map, 1),
              .key = KeyPlace::kOutside,
              .grid = false};
  for (int outcome = 0; outcome < kStabilityOutcomes; ++outcome)
    chart.series.push_back(MakeSquares(map, outcomes, outcome));
  ChartSeries curve{.title = line.title, .mark = Mark::kLinePoints, .colour = "#000000"};
  for (std::size_t i = 0; i < line.x.size(); ++i)
    curve.points.emplace_back(Position(map.values[0], line.x[i]),
                              Position(map.values[1], line.y[i]));
  chart.series.push_back(std::move(curve));
  WritePicture(path, {.width = 980, .height = 640, .font_size = 12, .charts = {std::move(chart)}});
}

}  // namespace drape
