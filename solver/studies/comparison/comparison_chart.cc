// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "physics/util/atomic_file.h"
#include "solver/job/plot/gnuplot.h"
#include "solver/studies/comparison/comparison_table.h"

namespace drape {
namespace {

constexpr int kRing = 6, kDisc = 7;  // gnuplot's point types

struct ModelPoint {
  std::string model;
  double rollouts = 0.0, own = 0.0, held_out = 0.0;
  double error = 0.0;                     // standard error of the difference from the best
  bool chosen = false, compared = false;  // not compared: a cell has no score
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

std::string Line(const char* format, auto... values) {
  char text[320];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

// Columns: line of the model, held out, its error, own, rollouts, mark, colour.
std::string MakeData(const std::vector<ModelPoint>& points) {
  std::string data = "$models << END\n";
  int line = 0;
  for (const ModelPoint& point : points)
    data += Line("%d %.9g %.9g %.9g %.9g %d %s\n", ++line, point.held_out, point.error, point.own,
                 point.rollouts, point.compared ? kDisc : kRing,
                 point.chosen ? "0xd62728" : "0x21918c");
  return data + "END\n";
}

// A line a model, the simplest above, with its name or bare.
std::string MakeLines(const std::vector<ModelPoint>& points, bool named) {
  std::string tics;
  for (std::size_t i = 0; i < points.size(); ++i)
    tics +=
        (tics.empty() ? "" : ", ") + Line("'%s' %zu", named ? points[i].model.c_str() : "", i + 1);
  return Line("set yrange [%zu.6:0.4]\n", points.size()) + "set ytics (" + tics + ") noenhanced\n";
}

// Drapes of other samples, a circle: a dashed line each where it is not far off.
std::string TrivialLines(const ComparisonTable& table, const std::vector<ModelPoint>& points) {
  double most = 0.0;
  for (const ModelPoint& point : points) most = std::max(most, point.held_out + point.error);
  std::string lines;
  for (const ComparisonRow& row : table.rows) {
    const auto energy = ComputeMean(row, "feature_energy");
    if (!energy || ComputeMean(row, "rollouts") || *energy > 2 * most) continue;
    lines += Line(
        ", '+' using (%.9g):($0 == 0 ? 0.4 : %zu.6) with lines dt 2 "
        "lc rgb '#555555' title '%s'",
        *energy, points.size(), row.model.c_str());
  }
  return lines;
}

// What a ring means, where there is one.
std::string RingKey(const std::vector<ModelPoint>& points) {
  const bool none = std::all_of(points.begin(), points.end(),
                                [](const ModelPoint& point) { return point.compared; });
  return none ? ""
              : Line(
                    ", NaN with points pt %d ps 1.3 lc rgb '#21918c' title "
                    "'a cell has no score: not compared'",
                    kRing);
}

// left, right: of the screen.
std::string MakePanel(double left, double right, const char* title, const char* axis,
                      const std::string& plots) {
  return Line("set lmargin at screen %g\nset rmargin at screen %g\n", left, right) +
         Line("set title '%s'\nset xlabel '%s'\n", title, axis) + "plot " + plots + "\n";
}

}  // namespace

void RenderModelChart(const std::string& path, const ComparisonTable& table) {
  const std::vector<ModelPoint> points = MakePoints(table);
  if (points.empty()) return;
  const std::string dots = " with points ps 1.3 pt variable lc rgb variable notitle";
  const std::string script =
      "set encoding utf8\nset grid lc rgb '#dddddd'\nset tics out\nset samples 2\n"
      "set offsets graph 0.05, graph 0.05, 0, 0\n"
      "set key at screen 0.01, 0.07 left Left reverse samplen 2 font ',9'\n"
      "set xtics rotate by -45 font ',9'\nset tmargin at screen 0.85\n"
      "set bmargin at screen 0.21\n" +
      MakeData(points) + MakeLines(points, true) +
      Line(
          "set multiplot layout 1,3 title '%s: the simplest model within one standard error of "
          "the best is red' font ',13'\n",
          table.fabric == 0 ? "All fabrics" : Line("Fabric %d", table.fabric).c_str()) +
      MakePanel(0.1, 0.42, "held-out drapes", "energy score of the features",
                "$models using 2:1:3:7 with xerrorbars pt 0 lc rgb variable notitle, "
                "$models using 2:1:6:7" +
                    dots + TrivialLines(table, points) + RingKey(points)) +
      MakeLines(points, false) +
      MakePanel(0.45, 0.7, "own silhouettes", "mean squared error of the image",
                "$models using 4:1:6:7" + dots) +
      "set logscale x\n" +
      MakePanel(0.73, 0.98, "cost of the fit", "rollouts", "$models using 5:1:6:7" + dots) +
      "unset multiplot\n";
  WriteFileAtomically(path + ".png",
                      RunGnuplot("set terminal pngcairo size 1100,520 font 'Sans,11'\n" + script));
  WriteFileAtomically(
      path + ".svg",
      RunGnuplot("set terminal svg size 1100,520 font 'Sans,11' background 'white'\n" + script));
}

}  // namespace drape
