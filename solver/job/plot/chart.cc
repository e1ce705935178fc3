// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/chart.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/stored/build.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/chart_json.h"
#include "solver/job/plot/gnuplot.h"

namespace drape {
namespace {

// Distinguishable with any colour vision [Okabe 2008]; further series are dashed.
constexpr const char* kColours[] = {"#000000", "#0072b2", "#e69f00", "#009e73",
                                    "#d55e00", "#cc79a7", "#56b4e9"};
constexpr int kNumColours = 7;
// Colours that differ in lightness as well ("viridis", Smith and van der Walt), without the
// lightest yellow.
constexpr char kPalette[] =
    "set palette defined (0 '#440154', .25 '#3b528b', .5 '#21918c', .75 '#5ec962', 1 '#e3ca10')\n";

// A text that gnuplot shows as it is.
std::string Literal(const std::string& text) { return QuoteForGnuplot(text) + " noenhanced"; }

// gnuplot takes the text of a tick for a format of its value.
std::string TickText(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '%' ? "%%" : std::string(1, c);
  return QuoteForGnuplot(escaped);
}

std::string Number(double value) {
  std::string text;
  AppendNumber(text, value);
  return text;
}

int SymbolNumber(Symbol symbol) {
  constexpr int kNumbers[] = {7, 5, 9, 13, 11, 15, 6, 2};
  return kNumbers[static_cast<int>(symbol)];
}

bool IsShown(const Chart& chart, const Eigen::Vector2d& point) {
  return point.allFinite() && (!chart.x.log || point.x() > 0) && (!chart.y.log || point.y() > 0);
}

bool HasPoints(const Chart& chart, const ChartSeries& series) {
  return std::any_of(series.points.begin(), series.points.end(),
                     [&](const Eigen::Vector2d& point) { return IsShown(chart, point); });
}

bool IsOnColourAxis(const ChartSeries& series) {
  return !series.values.empty() && series.mark != Mark::kErrorBars;
}

std::string MakeData(const Chart& chart, const ChartSeries& series, const std::string& name) {
  const bool needs_values = series.mark == Mark::kErrorBars || series.mark == Mark::kPolygons;
  CHECK(series.values.size() == series.points.size() || (series.values.empty() && !needs_values))
      << series.title;
  std::string data = name + " << END\n";
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const bool has_value = series.values.empty() || std::isfinite(series.values[i]);
    if (!has_value || !IsShown(chart, series.points[i])) {
      data += "\n\n";
      continue;
    }
    AppendNumber(data, series.points[i].x());
    AppendNumber(data += ' ', series.points[i].y());
    if (!series.values.empty()) AppendNumber(data += ' ', series.values[i]);
    data += '\n';
  }
  return data + "END\n";
}

std::string Look(const ChartSeries& series, int index) {
  const std::string colour =
      " lc rgb '" + (series.colour.empty() ? kColours[index % kNumColours] : series.colour) + "'";
  const bool dashed = series.dashed || (series.colour.empty() && index >= kNumColours);
  const std::string line = Format(" lw %g dt %d", series.width, dashed ? 2 : 1) + colour;
  const std::string points = Format(" pt %d ps %g", SymbolNumber(series.symbol), series.size);
  switch (series.mark) {
    case Mark::kLine:
      return "with lines" + line;
    case Mark::kSteps:
      return "with steps" + line;
    case Mark::kLinePoints:
      return "with linespoints" + points + line;
    case Mark::kPoints:
      return "with points" + points + (series.values.empty() ? colour : " lc palette");
    case Mark::kErrorBars:
      return "with xerrorbars" + points + colour;
    case Mark::kBars:
      return "with boxes fs solid noborder" + colour;
    case Mark::kSquares:
      return "with boxxyerror fs solid border rgb '#ffffff' fc rgb" + colour.substr(7);
    case Mark::kPolygons:
      return "with filledcurves closed fs solid noborder fc palette";
  }
  return "";
}

std::string Columns(const ChartSeries& series) {
  if (series.mark == Mark::kBars) return " using 1:2:(0.6) ";
  if (series.mark == Mark::kSquares) return " using 1:2:(0.48):(0.48) ";
  return series.values.empty() ? " using 1:2 " : " using 1:2:3 ";
}

std::string KeyEntry(const std::string& look) {
  return look.starts_with("with boxxyerror") ? "with boxes" + look.substr(15) : look;
}

// The data of all series, and the command that plots them.
std::string MakePlot(const Chart& chart, int number) {
  std::string data, plot;
  bool any = false;
  for (int i = 0; i < static_cast<int>(chart.series.size()); ++i) {
    const ChartSeries& series = chart.series[i];
    const std::string name = Format("$d%d_%d", number, i), look = Look(series, i);
    const std::string title = series.title.empty() ? " notitle" : " title " + Literal(series.title);
    const bool is_entry = series.mark == Mark::kSquares && !series.title.empty();
    if (!HasPoints(chart, series) && !is_entry) continue;
    plot += plot.empty() ? "plot " : ", ";
    if (!HasPoints(chart, series)) {
      plot += "keyentry " + KeyEntry(look) + title;
      continue;
    }
    any = true;
    data += MakeData(chart, series, name);
    plot += name + Columns(series) + look + title;
  }
  if (any) return data + plot + "\n";
  return "set xrange [1:10]\nset yrange [1:10]\nset label 'nothing to show' at graph 0.5,0.5 "
         "center\nplot NaN notitle\n";
}

// Of the axis that `get` takes of a point, on its scale.
std::pair<double, double> DataRange(const Chart& chart, bool is_y) {
  const bool log = is_y ? chart.y.log : chart.x.log;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const ChartSeries& series : chart.series)
    for (std::size_t i = 0; i < series.points.size(); ++i) {
      if (!IsShown(chart, series.points[i])) continue;
      const double value = series.points[i][is_y ? 1 : 0];
      const bool bar = !is_y && !log && series.mark == Mark::kErrorBars && !series.values.empty();
      const double half = bar ? series.values[i] : 0.0;
      least = std::min(least, log ? std::log10(value) : value - half);
      most = std::max(most, log ? std::log10(value) : value + half);
    }
  return {least, most};
}

std::string Range(const std::string& axis, double first, double last) {
  return "set " + axis + "range [" + Number(first) + ":" + Number(last) + "]\n";
}

// Where a logarithmic axis of so many decades has its marks: enough, and apart from each other.
std::vector<double> MarkedDigits(double decades) {
  constexpr double kFew = 0.8, kMany = 2.5;
  if (decades < kFew) return {1, 1.5, 2, 3, 4, 5, 6, 8};
  if (decades < kMany) return {1, 2, 5};
  return {1};
}

std::string RoundTicks(const std::string& axis, double low, double high) {
  std::string ticks;
  for (int decade = static_cast<int>(std::floor(low)); decade <= high; ++decade)
    for (const double digit : MarkedDigits(high - low))
      ticks += (ticks.empty() ? "" : ",") + Format("%.9g", digit * std::pow(10.0, decade));
  return "set format " + axis + " '%g'\nset " + axis + "tics (" + ticks + ")\n";
}

std::string MakeRange(const Chart& chart, const ChartAxis& axis, const std::string& name) {
  if (axis.range) {
    const auto [first, last] = *axis.range;
    return Range(name, first, last);
  }
  if (axis.room == 0.0) return "";
  const auto [least, most] = DataRange(chart, name == "y");
  if (!(least <= most)) return "";
  const double shortest = axis.log ? 0.5 : 1e-3 * std::max(std::abs(least), std::abs(most));
  const double room = axis.room * std::max(most - least, shortest);
  const double low = least - room, high = most + room;
  if (!axis.log) return Range(name, low, high);
  return Range(name, std::pow(10.0, low), std::pow(10.0, high)) + RoundTicks(name, low, high);
}

std::string MakeTicks(const ChartAxis& axis, const std::string& name) {
  std::string script;
  if (axis.tilt != 0) script += Format("set %stics rotate by %d\n", name.c_str(), axis.tilt);
  if (!axis.ticks) return script;
  std::string list;
  for (const auto& [value, text] : *axis.ticks)
    list += (list.empty() ? "" : ", ") + TickText(text) + " " + Number(value);
  return script + "set " + name + "tics (" + list + ") noenhanced\n";
}

std::string MakeAxis(const Chart& chart, const ChartAxis& axis, const std::string& name) {
  std::string script =
      "set " + name + "label " + Literal(axis.label) + (name == "cb" ? " offset 1,0\n" : "\n");
  if (axis.log) script += "set logscale " + name + "\n";
  script += "set format " + name + (axis.log && name != "cb" ? " '10^{%L}'\n" : " '%g'\n");
  return script + MakeRange(chart, axis, name) + MakeTicks(axis, name);
}

std::string MakeKey(const Chart& chart) {
  constexpr const char* kPlaces[] = {"inside top right",  "inside top left",
                                     "inside top center", "inside bottom right",
                                     "outside right top", "off"};
  constexpr char kStyle[] = " vertical Left reverse samplen 2 spacing 1.1 noenhanced\n";
  if (chart.key_at)
    return "set key at screen " + Number(chart.key_at->x()) + "," + Number(chart.key_at->y()) +
           " left top font ',9'" + kStyle;
  if (chart.key == KeyPlace::kNone) return "unset key\n";
  return std::string("set key ") + kPlaces[static_cast<int>(chart.key)] + kStyle;
}

std::string MakeBox(const ChartBox& box) {
  return "set lmargin at screen " + Number(box.left) + "\nset rmargin at screen " +
         Number(box.right) + "\nset bmargin at screen " + Number(box.bottom) +
         "\nset tmargin at screen " + Number(box.top) + "\n";
}

std::string MakeLabel(const ChartLabel& label) {
  constexpr const char* kAligns[] = {"left", "center", "right"};
  const std::string place = label.in_picture ? "screen " : "first ";
  return "set label " + Literal(label.text) + " at " + place + Number(label.at.x()) + "," + place +
         Number(label.at.y()) + " " + kAligns[static_cast<int>(label.align)] +
         Format(" offset %g,%g font ',%d' front\n", label.offset.x(), label.offset.y(),
                label.font_size);
}

std::string MakeChart(const Chart& chart, int number) {
  std::string script = "reset\nset tics out nomirror\n";
  if (chart.grid) script += "set grid lt 1 lw 0.5 lc rgb '#e0e0e0'\n";
  if (chart.equal_units) script += "set size ratio -1\n";
  if (chart.box) script += MakeBox(*chart.box);
  if (!chart.title.empty()) script += "set title " + Literal(chart.title) + "\n";
  script += MakeAxis(chart, chart.x, "x") + MakeAxis(chart, chart.y, "y");
  if (std::any_of(chart.series.begin(), chart.series.end(), IsOnColourAxis))
    script += kPalette + MakeAxis(chart, chart.colour, "cb");
  script += MakeKey(chart);
  for (const ChartLabel& label : chart.labels) script += MakeLabel(label);
  return script + MakePlot(chart, number);
}

// Which build drew the picture, in its lower right corner.
ChartLabel MakeStamp() {
  return {.text = BuildName(),
          .at = {0.995, 0.012},
          .in_picture = true,
          .align = ChartLabel::Align::kRight,
          .font_size = 7};
}

std::string MakeScript(const Picture& picture, bool svg) {
  constexpr int kWidth = 620, kHeight = 440;
  const int count = static_cast<int>(picture.charts.size());
  const int across = std::clamp(count, 1, picture.columns), down = (count + across - 1) / across;
  const int width = picture.width > 0 ? picture.width : kWidth * across;
  const int height = picture.height > 0 ? picture.height : kHeight * down;
  std::string script = "set encoding utf8\nset terminal " +
                       Format(svg ? "svg size %d,%d font 'Sans,%d' background 'white'\n"
                                  : "pngcairo size %d,%d font 'Sans,%d'\n",
                              width, height, picture.font_size);
  script += Format("set multiplot layout %d,%d", down, across);
  if (!picture.title.empty())
    script += " title " + Literal(picture.title) + Format(" font ',%d'", picture.font_size + 2);
  script += "\n";
  std::vector<Chart> charts = picture.charts;
  if (!charts.empty()) charts.back().labels.push_back(MakeStamp());
  for (int i = 0; i < count; ++i) script += MakeChart(charts[i], i);
  return script + "unset multiplot\n";
}

// Where TryPictures keeps why a picture could not be drawn, so that others are still described.
thread_local std::string* undrawn = nullptr;

}  // namespace

void WritePicture(const std::string& path, const Picture& picture) {
  if (path.ends_with(".png")) WriteFileAtomically(ChartPath(path), PictureText(picture));
  std::string drawn;
  try {
    drawn = RunGnuplot(MakeScript(picture, path.ends_with(".svg")));
  } catch (const InputError& error) {
    if (undrawn == nullptr) throw;
    if (undrawn->empty()) *undrawn = error.what();
    return;
  }
  WriteFileAtomically(path, drawn);
}

std::string TryPictures(const std::function<void()>& write) {
  std::string why;
  undrawn = &why;
  const std::shared_ptr<void> reset(nullptr, [](void*) { undrawn = nullptr; });
  try {
    write();
  } catch (const std::runtime_error& error) {
    if (why.empty()) why = error.what();
  }
  return why.empty() ? "" : "no pictures: " + why + "\n";
}

}  // namespace drape
