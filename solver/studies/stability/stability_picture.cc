// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_picture.h"

#include <glog/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"

namespace drape {
namespace {

// In the order of StabilityOutcome: greens for what came to rest at its place or will, warm colours
// for wrong answers, dark ones for none.
constexpr const char* kColours[kStabilityOutcomes] = {"#1a9850", "#a6d96a", "#fee08b", "#f46d43",
                                                      "#a50026", "#762a83", "#4d4d4d", "#1a9850",
                                                      "#a50026", "#fdae61", "#f46d43", "#4575b4"};

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

const char* Describe(StabilityMethod method) {
  constexpr const char* kTexts[kStabilityMethods] = {"explicit Euler",
                                                     "one solve per step",
                                                     "one solve, conjugate gradients",
                                                     "one solve, single precision",
                                                     "implicit Euler, converged",
                                                     "one solve, penalty",
                                                     "Newton to rest",
                                                     "Newton, shift by the mass",
                                                     "Newton, no shift",
                                                     "Newton, projected elements"};
  return kTexts[static_cast<int>(method)];
}

const char* Describe(StabilityScenario scenario) {
  constexpr const char* kTexts[kStabilityScenarios] = {
      "drape",  "drape and support", "ball", "thin plate", "rod", "two sheets", "slope", "skid",
      "pinched"};
  return kTexts[static_cast<int>(scenario)];
}

// "density [kg/m²]" and .1 → "density 0.1 kg/m²"; "bend stiffness [factor]" and 10 → "bend
// stiffness times 10".
std::string Describe(const StabilityAxis& axis, double value) {
  const std::string label = axis.label;
  const std::size_t bracket = label.find(" [");
  if (bracket == std::string::npos) return label + Format(" %.4g", value);
  const std::string name = label.substr(0, bracket),
                    unit = label.substr(bracket + 2, label.size() - bracket - 3);
  return unit == "factor" ? name + Format(" times %.4g", value)
                          : name + Format(" %.4g ", value) + unit;
}

// The method, the scenario and what else is unusual besides the axes: "explicit Euler, drape,
// density 0.1 kg/m²".
std::string MakeTitle(const StabilityMap& map) {
  const StabilityCase usual;
  std::string title = std::string(Describe(map.base.method)) + ", " + Describe(map.base.scenario);
  if (map.base.law != usual.law) title += ", law " + map.base.law;
  std::vector<double StabilityCase::*> named;
  for (const StabilityAxis& axis : StabilityAxes()) {
    const double value = map.base.*axis.fields[0];
    const bool is_news = std::all_of(axis.fields.begin(), axis.fields.end(), [&](auto field) {
      return map.base.*field == value && value != usual.*field &&
             std::find(named.begin(), named.end(), field) == named.end();
    });
    if (!is_news) continue;
    title += ", " + Describe(axis, value);
    named.insert(named.end(), axis.fields.begin(), axis.fields.end());
  }
  return title;
}

// The overview: a row for each method and a column for each hardship.
struct Heading {
  const char* text;
  std::vector<std::string> axes;  // that belong to it; none: all maps of the scenario
  StabilityScenario scenario = StabilityScenario::kDrape;
};
const std::vector<Heading>& Hardships() {
  using Scenario = StabilityScenario;
  static const std::vector<Heading> headings = {{"stiffness", {"stiffness", "stretch", "bend"}},
                                                {"density", {"density"}},
                                                {"needles", {"sliver"}},
                                                {"compressed", {"compression"}},
                                                {"tangled", {"tangle"}},
                                                {"handles", {"handle"}},
                                                {"support", {}, Scenario::kSupport},
                                                {"ball", {}, Scenario::kBall},
                                                {"thin plate", {}, Scenario::kPlate},
                                                {"rod", {}, Scenario::kRod},
                                                {"two sheets", {}, Scenario::kSheets},
                                                {"slope", {}, Scenario::kSlope},
                                                {"skid", {}, Scenario::kSkid},
                                                {"pinched", {}, Scenario::kPinch}};
  return headings;
}

using Counts = std::array<int, kStabilityOutcomes>;

// Of a method under a hardship, over all maps of the smooth law.
Counts CountOutcomes(const StabilityAtlas& atlas, StabilityMethod method, const Heading& heading) {
  Counts counts = {};
  for (const StabilityMap& map : atlas.maps) {
    const auto belongs = [&](const StabilityAxis* axis) {
      return std::find(heading.axes.begin(), heading.axes.end(), axis->name) != heading.axes.end();
    };
    if (map.base.method != method || map.base.law != "smooth" ||
        map.base.scenario != heading.scenario ||
        !(heading.axes.empty() || belongs(map.axis[0]) || belongs(map.axis[1])))
      continue;
    for (const int outcome : atlas.ListOutcomes(map))
      if (outcome != kNoRun) ++counts[outcome];
  }
  return counts;
}

struct ShareClass {
  double least;  // share of settled runs
  const char* title;
  const char* colour;
};
constexpr ShareClass kShares[] = {{0.9, "at least 90 % succeed", "#66bd63"},
                                  {0.7, "70 to 90 %", "#b8e186"},
                                  {0.4, "40 to 70 %", "#fee08b"},
                                  {0.0, "less", "#f4a582"}};

bool IsSuccess(int outcome) {
  const auto which = static_cast<StabilityOutcome>(outcome);
  return which == StabilityOutcome::kSettled || which == StabilityOutcome::kHolds;
}

// "83 % m": the share that succeeds, and the letter of the most frequent failure.
void AddCell(Counts counts, double x, double y, Chart* chart) {
  const int runs = std::accumulate(counts.begin(), counts.end(), 0);
  if (runs == 0) {
    chart->labels.push_back(
        {.text = "not run", .at = {x, y}, .align = ChartLabel::Align::kCentre, .font_size = 9});
    return;
  }
  for (int i = 0; i < kStabilityOutcomes; ++i)
    if (IsSuccess(i)) counts[i] = 0;
  const int failures = std::accumulate(counts.begin(), counts.end(), 0);
  const double share = 1.0 - static_cast<double>(failures) / runs;
  std::size_t shade = 0;
  while (share < kShares[shade].least) ++shade;
  chart->series[shade].points.emplace_back(x, y);
  std::string text = Format("%.0f %%", 100.0 * share);
  if (failures > 0) {
    const auto worst = std::max_element(counts.begin(), counts.end());
    text +=
        std::string(" ") + StabilityLetter(static_cast<StabilityOutcome>(worst - counts.begin()));
  }
  chart->labels.push_back(
      {.text = text, .at = {x, y}, .align = ChartLabel::Align::kCentre, .font_size = 11});
}

// Of those failures that any run has had.
std::string ExplainLetters(const Counts& all) {
  std::string text = "letter: the most frequent failure";
  bool is_first = true;
  for (int i = 0; i < kStabilityOutcomes; ++i) {
    if (all[i] == 0 || IsSuccess(i)) continue;
    const auto outcome = static_cast<StabilityOutcome>(i);
    text +=
        std::string(is_first ? ": " : ", ") + StabilityLetter(outcome) + " " + ToString(outcome);
    is_first = false;
  }
  return text;
}

// The methods and hardships that have runs.
struct OverviewGrid {
  std::vector<StabilityMethod> rows;
  std::vector<const Heading*> columns;
  Counts all = {};
};
OverviewGrid MakeGrid(const StabilityAtlas& atlas) {
  OverviewGrid grid;
  std::array<bool, kStabilityMethods> has_row = {};
  for (const Heading& heading : Hardships()) {
    bool has_column = false;
    for (int row = 0; row < kStabilityMethods; ++row) {
      const Counts counts = CountOutcomes(atlas, static_cast<StabilityMethod>(row), heading);
      if (std::accumulate(counts.begin(), counts.end(), 0) == 0) continue;
      has_column = has_row[row] = true;
      for (int i = 0; i < kStabilityOutcomes; ++i) grid.all[i] += counts[i];
    }
    if (has_column) grid.columns.push_back(&heading);
  }
  for (int row = 0; row < kStabilityMethods; ++row)
    if (has_row[row]) grid.rows.push_back(static_cast<StabilityMethod>(row));
  return grid;
}

}  // namespace

void RenderStabilityOverview(const std::string& path, const StabilityAtlas& atlas) {
  constexpr double kRoom = 0.5;
  const OverviewGrid grid = MakeGrid(atlas);
  Chart chart{.title = ExplainLetters(grid.all), .key = KeyPlace::kOutside, .grid = false};
  for (const ShareClass& shade : kShares)
    chart.series.push_back({.title = shade.title, .mark = Mark::kSquares, .colour = shade.colour});
  const auto rows = static_cast<int>(grid.rows.size());
  const auto columns = static_cast<int>(grid.columns.size());
  chart.x = {.range = {{-kRoom, columns - kRoom}}};
  chart.y = {.range = {{rows - kRoom, -kRoom}}};
  chart.x.ticks.emplace();
  chart.y.ticks.emplace();
  for (int row = 0; row < rows; ++row) {
    chart.y.ticks->emplace_back(row, Describe(grid.rows[row]));
    for (int column = 0; column < columns; ++column)
      AddCell(CountOutcomes(atlas, grid.rows[row], *grid.columns[column]), column, row, &chart);
  }
  for (int column = 0; column < columns; ++column)
    chart.x.ticks->emplace_back(column, grid.columns[column]->text);
  WritePicture(path, {.title = "Share of runs that succeed, by solver and by what is varied",
                      .width = 1100,
                      .height = 160 + 36 * std::max(rows, 4),
                      .charts = {std::move(chart)}});
}

void RenderStabilityMap(const std::string& path, const StabilityMap& map,
                        const std::vector<int>& outcomes, const StabilityLine& line) {
  CHECK_EQ(outcomes.size(), map.values[0].size() * map.values[1].size());
  Chart chart{.title = MakeTitle(map),
              .x = MakeAxis(map, 0),
              .y = MakeAxis(map, 1),
              .key = KeyPlace::kOutside,
              .grid = false};
  for (int outcome = 0; outcome < kStabilityOutcomes; ++outcome)
    if (ChartSeries squares = MakeSquares(map, outcomes, outcome); !squares.points.empty())
      chart.series.push_back(std::move(squares));
  ChartSeries curve{.title = line.title, .mark = Mark::kLinePoints, .colour = "#000000"};
  for (std::size_t i = 0; i < line.x.size(); ++i)
    curve.points.emplace_back(Position(map.values[0], line.x[i]),
                              Position(map.values[1], line.y[i]));
  chart.series.push_back(std::move(curve));
  WritePicture(path, {.width = 980, .height = 640, .font_size = 12, .charts = {std::move(chart)}});
}

}  // namespace drape
