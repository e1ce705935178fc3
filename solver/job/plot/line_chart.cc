// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/line_chart.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/util/atomic_file.h"
#include "physics/util/text_format.h"
#include "solver/job/plot/gnuplot.h"

namespace drape {
namespace {

// Told apart by people who see colours differently, in the order of [Okabe 2008], then
// again dashed.
constexpr const char* kColours[] = {"#000000", "#0072b2", "#e69f00", "#009e73",
                                    "#d55e00", "#cc79a7", "#56b4e9"};
constexpr int kNumColours = 7;

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '"' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

bool Drawn(const Chart& chart, const Eigen::Vector2d& point) {
  return point.allFinite() && (!chart.log_x || point.x() > 0) && (!chart.log_y || point.y() > 0);
}

std::string MakeData(const Chart& chart, const ChartLine& line, const std::string& name) {
  std::string data = Format("$%s << END\n", name.c_str());
  for (const Eigen::Vector2d& point : line.points) {
    if (Drawn(chart, point)) {
      AppendNumber(data, point.x());
      data += ' ';
      AppendNumber(data, point.y());
    }
    data += '\n';  // an empty line is a gap
  }
  return data + "END\n";
}

std::string LineStyle(const Chart& chart, const ChartLine& line, int index) {
  const std::string look = std::string(" lw 2 dt ") + (index < kNumColours ? "1" : "2") +
                           " lc rgb '" + kColours[index % kNumColours] + "'";
  if (chart.steps) return "with steps" + look;
  return line.marked ? "with linespoints pt 7 ps 0.6" + look : "with lines" + look;
}

std::string MakeScript(const Chart& chart, int number) {
  std::string script, plot;
  for (int i = 0; i < static_cast<int>(chart.lines.size()); ++i) {
    const ChartLine& line = chart.lines[i];
    const bool any = std::any_of(line.points.begin(), line.points.end(),
                                 [&](const Eigen::Vector2d& p) { return Drawn(chart, p); });
    if (!any) continue;
    const std::string name = Format("d%d_%d", number, i);
    script += MakeData(chart, line, name);
    plot += (plot.empty() ? "plot $" : ", $") + name + " using 1:2 " + LineStyle(chart, line, i) +
            (line.title.empty() ? " notitle" : " title \"" + Escaped(line.title) + "\"");
  }
  script += chart.log_x ? "set logscale x\nset format x '10^{%L}'\n"
                        : "unset logscale x\nset format x '%g'\n";
  script += chart.log_y ? "set logscale y\nset format y '10^{%L}'\n"
                        : "unset logscale y\nset format y '%g'\n";
  script += "set title \"" + Escaped(chart.title) + "\"\nset xlabel \"" + Escaped(chart.x_label) +
            "\"\nset ylabel \"" + Escaped(chart.y_label) + "\"\nset yrange [" + chart.y_range +
            "]\nset key " + chart.key + "\n";
  if (plot.empty())
    plot =
        "set xrange [1:10]\nset yrange [1:10]\nset label 1 'nothing to show' at graph 0.5,0.5 "
        "center\nplot NaN notitle\nunset label 1\nset autoscale x";
  return script + plot + "\n";
}

std::string Terminal(int width, int height) {
  return "set encoding utf8\nset terminal pngcairo size " + std::to_string(width) + "," +
         std::to_string(height) + " font 'Sans,11'\nset grid lc rgb '#dddddd'\nset tics out\n";
}

}  // namespace

void RenderCharts(const std::string& path, const std::vector<Chart>& charts, int columns) {
  const int count = static_cast<int>(charts.size());
  const int across = std::min(count, columns), down = (count + columns - 1) / columns;
  std::string script = Terminal(620 * across, 440 * down) + "set key noenhanced\n";
  script += "set multiplot layout " + std::to_string(down) + "," + std::to_string(across) + "\n";
  for (int i = 0; i < count; ++i) script += MakeScript(charts[i], i);
  WriteFileAtomically(path, RunGnuplot(script + "unset multiplot\n"));
}

void DrawShares(const std::string& path, const std::string& title,
                const std::vector<std::pair<std::string, double>>& shares) {
  std::string script = Terminal(820, 420) + "$shares << END\n";
  for (const auto& [name, share] : shares) {
    script += '"';
    script += Escaped(name);
    script += Format("\" %.6g\n", share);
  }
  script += "END\nset title \"" + Escaped(title) +
            "\"\nset yrange [0:1.1]\nset ylabel 'share of the problems'\nset boxwidth 0.6\n"
            "set style fill solid noborder\nset xtics rotate by -30 noenhanced\n"
            "plot $shares using 0:2:xtic(1) with boxes lc rgb '#0072b2' notitle, "
            "$shares using 0:($2+0.04):(sprintf('%.2f', $2)) with labels notitle\n";
  WriteFileAtomically(path, RunGnuplot(script));
}

}  // namespace drape
