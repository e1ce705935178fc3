// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/bench/bench_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "physics/util/atomic_file.h"
#include "solver/job/plot/gnuplot.h"
#include "solver/studies/bench/pareto.h"

namespace drape {
namespace {

constexpr int kMarks[] = {7, 5, 9, 13, 11, 15};  // gnuplot's filled ones
constexpr char kColours[][8] = {"#21918c", "#440154", "#d95f02", "#3b528b", "#5ec962", "#7f7f7f"};

std::string Number(double value, const char* format = "%.3g") {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// A text between double quotes of gnuplot, without its markup.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\" noenhanced";
}

void WritePictures(const std::string& path, const std::string& script) {
  const std::string common = "set encoding utf8\n";
  WriteFileAtomically(path + ".png", RunGnuplot(common +
                                                "set terminal pngcairo size 1100,640 font "
                                                "'Sans,11'\n" +
                                                script));
  WriteFileAtomically(path + ".svg", RunGnuplot(common +
                                                "set terminal svg size 1100,640 font "
                                                "'Sans,11' background 'white'\n" +
                                                script));
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
  std::vector<ChartPoint> standing, front;
  for (const ChartPoint& point : points)
    if (point.on_branch) standing.push_back(point);
  for (const ChartPoint& point : standing) candidates.push_back({point.cost, point.error});
  for (const int i : ParetoFront(candidates)) front.push_back(standing[i]);
  return front;
}

void AppendTic(std::string* tics, double value) {
  if (!tics->empty()) *tics += ',';
  *tics += Number(value, "%.9g");
}

// Where a logarithmic axis of so many decades has its marks: enough, and apart from each other.
std::vector<double> MarkedDigits(double decades) {
  constexpr double kFew = 0.8, kMany = 2.5;
  if (decades < kFew) return {1, 1.5, 2, 3, 4, 5, 6, 8};
  if (decades < kMany) return {1, 2, 5};
  return {1};
}

// A logarithmic axis that holds the values with some room.
std::string LogAxis(const std::string& axis, const std::vector<double>& values) {
  constexpr double kRoom = 0.12;  // of the axis
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double low = std::log10(*least), high = std::log10(*most);
  const double room = kRoom * std::max(high - low, 0.5);
  std::string tics;
  for (int decade = static_cast<int>(std::floor(low)) - 1; decade <= high + 1; ++decade)
    for (const double digit : MarkedDigits(high - low))
      AppendTic(&tics, digit * std::pow(10.0, decade));
  return "set " + axis + "range [" + Number(std::pow(10.0, low - room), "%.9g") + ":" +
         Number(std::pow(10.0, high + room), "%.9g") + "]\nset " + axis + "tics (" + tics + ")\n";
}

std::string VertexTics(const std::string& axis, const std::vector<double>& vertices) {
  std::string tics;
  for (const double value : std::set<double>(vertices.begin(), vertices.end()))
    AppendTic(&tics, value);
  return "set " + axis + "tics (" + tics + ")\n";
}

template <class Get>
std::vector<double> Column(const std::vector<ChartPoint>& points, const Get& get) {
  std::vector<double> column;
  for (const ChartPoint& point : points) column.push_back(get(point));
  return column;
}

std::string FrontAxes(const FrontChart& chart, const std::vector<ChartPoint>& points) {
  std::vector<double> errors = Column(points, [](const auto& p) { return p.error; });
  if (chart.reference_error > 0) errors.push_back(chart.reference_error);
  return LogAxis("x", Column(points, [](const auto& p) { return p.cost; })) + LogAxis("y", errors) +
         VertexTics("cb", Column(points, [](const auto& p) { return p.vertices; }));
}

// Numbers of the front's points beside them; those of near points in one text.
std::string NumberLabels(const std::vector<ChartPoint>& front) {
  constexpr double kNear = 0.07;  // decades
  std::string labels;
  for (std::size_t i = 0; i < front.size();) {
    std::string text = Number(static_cast<double>(i + 1));
    std::size_t next = i + 1;
    for (; next < front.size() && std::log10(front[next].cost / front[i].cost) < kNear &&
           std::log10(front[i].error / front[next].error) < kNear;
         ++next)
      AppendTic(&text, static_cast<double>(next + 1));
    labels += "set label " + Quoted(text) + " at " + Number(front[i].cost, "%.9g") + "," +
              Number(front[i].error, "%.9g") + " right offset -0.7,-0.7 font ',10' front\n";
    i = next;
  }
  return labels;
}

std::string FrontList(const FrontChart& chart, const std::vector<ChartPoint>& front) {
  constexpr double kTop = 0.86, kLine = 0.036;
  constexpr std::size_t kMost = 15;
  std::string labels = "set label " + Quoted("Pareto front: seconds, error, setting") +
                       " at screen 0.665," + Number(kTop + 0.045) + " left font ',10'\n";
  const std::size_t shown = std::min(front.size(), kMost);
  for (std::size_t i = 0; i < shown; ++i) {
    const std::string text = std::to_string(i + 1) + "  " + Number(front[i].cost) + "  " +
                             Number(front[i].error) + "  " + front[i].label;
    labels += "set label " + Quoted(text) + " at screen 0.665," +
              Number(kTop - kLine * static_cast<double>(i), "%.4f") + " left font ',9'\n";
  }
  if (front.size() > shown || chart.points.empty())
    labels += "set label " + Quoted("… all in bench.json") + " at screen 0.665," +
              Number(kTop - kLine * static_cast<double>(shown), "%.4f") + " left font ',9'\n";
  return labels;
}

template <class Keep>
std::string DataBlock(const std::string& name, const std::vector<ChartPoint>& points,
                      const Keep& keep) {
  std::string data = "$" + name + " << END\n";
  for (const ChartPoint& point : points)
    if (keep(point))
      data += Number(point.cost, "%.9g") + " " + Number(point.error, "%.9g") + " " +
              Number(point.vertices, "%.9g") + "\n";
  return data + "END\n";
}

bool HasData(const std::vector<ChartPoint>& points, int series, bool on_branch) {
  return std::any_of(points.begin(), points.end(), [&](const ChartPoint& point) {
    return point.on_branch == on_branch && (series < 0 || point.series == series);
  });
}

std::string FrontPlots(const FrontChart& chart, const std::vector<ChartPoint>& points) {
  std::string plots;
  const auto add = [&](const std::string& plot) {
    plots += (plots.empty() ? "plot " : ", ") + plot;
  };
  if (HasData(points, -1, false))
    add("$elsewhere using 1:2 with points pt 2 ps 1 lc rgb '#aaaaaa' title 'other branch'");
  add("$front using 1:2 with lines lw 2 lc rgb '#d62728' title 'Pareto front'");
  for (int s = 0; s < static_cast<int>(chart.series.size()); ++s)
    if (HasData(points, s, true))
      add("$series" + std::to_string(s) + " using 1:2:3 with points pt " +
          std::to_string(kMarks[s % std::size(kMarks)]) + " ps 1.5 lc palette title " +
          Quoted(chart.series[s]));
  if (chart.reference_error > 0)
    add(Number(chart.reference_error, "%.9g") +
        " with lines dt 2 lc rgb '#555555' title 'error of the reference, estimated'");
  return plots + "\n";
}

}  // namespace

void RenderFrontChart(const std::string& path, const FrontChart& chart) {
  const std::vector<ChartPoint> points = Usable(chart);
  const std::vector<ChartPoint> front = AccuracyFront(points);
  if (front.empty()) return;
  std::string script =
      "set logscale xycb\nset grid lc rgb '#dddddd'\nset tics out\n"
      "set format x '%g'\nset format y '%g'\nset format cb '%g'\n"
      "set palette defined (0 '#440154', .25 '#3b528b', .5 '#21918c', .75 '#5ec962', 1 '#d9c400')\n"
      "set lmargin at screen 0.07\nset rmargin at screen 0.55\nset tmargin at screen 0.92\n"
      "set bmargin at screen 0.10\nset colorbox user origin screen 0.565,0.10 size screen "
      "0.014,0.82\nset key at screen 0.66,0.24 left top vertical Left reverse samplen 1.5 font "
      "',9'\n";
  script += "set label " + Quoted(chart.title) + " at screen 0.5,0.975 center font ',13'\n";
  script += "set xlabel " + Quoted(chart.cost_name) + "\nset ylabel " + Quoted(chart.error_name) +
            "\nset cblabel 'vertices' offset 0.7,0\n";
  script += FrontAxes(chart, points) + NumberLabels(front) + FrontList(chart, front);
  for (int s = 0; s < static_cast<int>(chart.series.size()); ++s)
    script += DataBlock("series" + std::to_string(s), points, [&](const ChartPoint& point) {
      return point.on_branch && point.series == s;
    });
  script += DataBlock("elsewhere", points, [](const ChartPoint& p) { return !p.on_branch; });
  script += DataBlock("front", front, [](const ChartPoint&) { return true; });
  WritePictures(path, script + FrontPlots(chart, points));
}

void RenderGrowthChart(const std::string& path, const std::string& title,
                       const std::string& cost_name, const std::vector<GrowthSeries>& series) {
  if (series.empty()) return;
  std::string script =
      "set logscale xy\nset grid lc rgb '#dddddd'\nset tics out\n"
      "set format '%g'\nset key top left Left reverse samplen 2 font ',9'\n"
      "set xlabel 'vertices'\n";
  std::string plots[2];
  std::vector<double> vertices, seconds, megabytes;
  for (std::size_t s = 0; s < series.size(); ++s) {
    const GrowthSeries& one = series[s];
    script += "$growth" + std::to_string(s) + " << END\n";
    for (std::size_t i = 0; i < one.vertices.size(); ++i)
      script += Number(one.vertices[i], "%.9g") + " " + Number(one.seconds[i], "%.9g") + " " +
                Number(one.megabytes[i], "%.9g") + "\n";
    script += "END\n";
    vertices.insert(vertices.end(), one.vertices.begin(), one.vertices.end());
    seconds.insert(seconds.end(), one.seconds.begin(), one.seconds.end());
    megabytes.insert(megabytes.end(), one.megabytes.begin(), one.megabytes.end());
    const double exponents[] = {FittedExponent(one.vertices, one.seconds),
                                FittedExponent(one.vertices, one.megabytes)};
    for (int k = 0; k < 2; ++k)
      plots[k] += (s == 0 ? "plot " : ", ") + ("$growth" + std::to_string(s)) +
                  " using 1:" + std::to_string(k + 2) + " with linespoints pt " +
                  std::to_string(kMarks[s % std::size(kMarks)]) + " ps 1.3 lc rgb '" +
                  kColours[s % std::size(kColours)] + "' title " +
                  Quoted(one.name + ": V^" + Number(exponents[k], "%.2f"));
  }
  script += "set multiplot layout 1,2 title " + Quoted(title) + " font ',13'\n";
  script += LogAxis("x", vertices) + VertexTics("x", vertices);
  script += LogAxis("y", seconds) + "set ylabel " + Quoted(cost_name) + "\n" + plots[0] + "\n";
  script += LogAxis("y", megabytes) + "set ylabel 'peak memory [MB]'\n" + plots[1] +
            "\nunset multiplot\n";
  WritePictures(path, script);
}

}  // namespace drape
