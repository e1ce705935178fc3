// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "physics/atomic_file.h"
#include "solver/comparison_table.h"
#include "solver/gnuplot.h"

namespace drape {
namespace {

struct ModelPoint {
  std::string model;
  double rollouts = 0.0, own = 0.0, held_out = 0.0;
  double error = 0.0;  // standard error of the difference from the best
  bool chosen = false;
};

std::optional<double> MeanOf(const ComparisonRow& row, const std::string& key) {
  const auto found = row.numbers.find(key);
  if (found == row.numbers.end()) return std::nullopt;
  return found->second.spread.mean;
}

std::vector<ModelPoint> PointsOf(const ComparisonTable& table) {
  std::vector<ModelPoint> points;
  for (const ComparisonRow& row : table.rows) {
    const auto rollouts = MeanOf(row, "rollouts"), own = MeanOf(row, "train_mse"),
               held_out = MeanOf(row, "feature_energy");
    if (!rollouts || !own || !held_out) continue;
    ModelPoint point{row.model, *rollouts, *own, *held_out, 0.0, row.model == table.choice.chosen};
    for (const ScoreDifference& difference : table.choice.differences)
      if (difference.model == row.model) point.error = difference.standard_error;
    points.push_back(point);
  }
  return points;
}

std::string Line(const char* format, auto... values) {
  char text[320];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

// Columns: rollouts, own, held out, its error.
std::string DataOf(const std::vector<ModelPoint>& points, bool chosen) {
  std::string data = chosen ? "$chosen << END\n" : "$others << END\n";
  for (const ModelPoint& point : points)
    if (point.chosen == chosen)
      data += Line("%.9g %.9g %.9g %.9g\n", point.rollouts, point.own, point.held_out, point.error);
  return data + "END\n";
}

// Names beside the points, in turn above to the right and below to the left: near points keep
// theirs apart.
std::string NamesOf(std::vector<ModelPoint> points, double ModelPoint::*height) {
  std::sort(points.begin(), points.end(),
            [](const ModelPoint& a, const ModelPoint& b) { return a.rollouts < b.rollouts; });
  std::string labels = "unset label\n";
  bool right = false;
  for (const ModelPoint& point : points) {
    right = !right;
    labels += Line("set label '%s' at %.9g,%.9g %s font ',10' tc rgb '%s' front\n",
                   point.model.c_str(), point.rollouts, point.*height,
                   right ? "left offset 0.9,0.4" : "right offset -0.9,-0.4",
                   point.chosen ? "#d62728" : "#21918c");
  }
  return labels;
}

std::string PanelOf(int column, const char* title, const char* axis, bool bars,
                    const std::string& more, const std::vector<ModelPoint>& points) {
  std::string plots;
  for (const bool chosen : {false, true}) {
    if (std::none_of(points.begin(), points.end(),
                     [&](const ModelPoint& point) { return point.chosen == chosen; }))
      continue;
    const char* block = chosen ? "$chosen" : "$others";
    const char* colour = chosen ? "#d62728" : "#21918c";
    if (bars)
      plots +=
          Line("%s using 1:3:4 with yerrorbars pt 7 ps 1.3 lc rgb '%s' notitle, ", block, colour);
    else
      plots += Line("%s using 1:%d with points pt 7 ps 1.3 lc rgb '%s' notitle, ", block, column,
                    colour);
  }
  if (more.empty() && !plots.empty()) plots.resize(plots.size() - 2);
  return NamesOf(points, bars ? &ModelPoint::held_out : &ModelPoint::own) +
         Line("set title '%s'\nset ylabel '%s'\nplot ", title, axis) + plots + more + "\n";
}

}  // namespace

void DrawModelChart(const std::string& path, const ComparisonTable& table) {
  const std::vector<ModelPoint> points = PointsOf(table);
  if (points.empty()) return;
  double most = 0.0, least = points[0].rollouts, last = 0.0;
  for (const ModelPoint& point : points) {
    most = std::max(most, point.held_out + point.error);
    least = std::min(least, point.rollouts);
    last = std::max(last, point.rollouts);
  }
  std::string trivial;
  for (const ComparisonRow& row : table.rows) {
    const auto energy = MeanOf(row, "feature_energy");
    if (!energy || MeanOf(row, "rollouts") || *energy > 2 * most) continue;
    if (!trivial.empty()) trivial += ", ";
    trivial += Line("%.9g with lines dt 2 lc rgb '#555555' title '%s'", *energy, row.model.c_str());
  }
  const std::string script =
      "set encoding utf8\nset logscale x\nset grid lc rgb '#dddddd'\nset tics out\n"
      "set xlabel 'rollouts of the fit'\nset key bottom right samplen 2 font ',9'\n" +
      Line("set xrange [%.9g:%.9g]\nset offsets graph 0, graph 0, graph 0.08, graph 0.08\n",
           least / 2.5, last * 2.5) +
      DataOf(points, false) + DataOf(points, true) +
      Line(
          "set multiplot layout 1,2 title '%s: the simplest model within one standard error of "
          "the best is red' font ',13'\n",
          table.fabric == 0 ? "All fabrics" : Line("Fabric %d", table.fabric).c_str()) +
      PanelOf(2, "own silhouettes", "mean squared error of the image", false, "", points) +
      PanelOf(3, "held-out drapes", "energy score of the features", true, trivial, points) +
      "unset multiplot\n";
  WriteFileAtomically(path + ".png",
                      RunGnuplot("set terminal pngcairo size 1100,520 font 'Sans,11'\n" + script));
  WriteFileAtomically(
      path + ".svg",
      RunGnuplot("set terminal svg size 1100,520 font 'Sans,11' background 'white'\n" + script));
}

}  // namespace drape
