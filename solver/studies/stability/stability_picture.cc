// SPDX-License-Identifier: Apache-2.0
#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "physics/util/atomic_file.h"
#include "solver/job/plot/gnuplot.h"
#include "solver/studies/stability/stability_map.h"

namespace drape {
namespace {

// In the order of StabilityClass: greens for what came to rest at its place or will, warm colours
// for wrong answers, dark ones for none.
constexpr const char* kColours[kStabilityClasses] = {"#1a9850", "#a6d96a", "#fee08b", "#f46d43",
                                                     "#a50026", "#762a83", "#4d4d4d"};

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

// Squares have unit size, so positions between values go by the logarithm of these, or evenly where
// a value is zero.
double Position(const std::vector<double>& values, double value) {
  const auto scale = [&](double v) { return values.front() > 0.0 ? std::log(v) : v; };
  const std::size_t above = std::clamp<std::size_t>(
      std::upper_bound(values.begin(), values.end(), value) - values.begin(), 1, values.size() - 1);
  const double low = scale(values[above - 1]), high = scale(values[above]);
  return static_cast<double>(above) - 1.0 + (scale(value) - low) / (high - low);
}

std::string Ticks(const std::vector<double>& values) {
  constexpr std::size_t kMostTicks = 15;
  const std::size_t every = (values.size() + kMostTicks - 1) / kMostTicks;
  std::string ticks;
  for (std::size_t i = 0; i < values.size(); i += every)
    ticks += (i == 0 ? "'" : ", '") + Short(values[i]) + "' " + std::to_string(i);
  return "(" + ticks + ")";
}

std::string AxisText(const std::string& axis, const StabilityMap& map, int k) {
  return "set " + axis + "label '" + map.axis[k]->label + "'\nset " + axis + "tics " +
         Ticks(map.values[k]) + "\nset " + axis +
         "range [-0.5:" + std::to_string(map.values[k].size() - 1) + ".5]\n";
}

std::string Squares(const StabilityMap& map, const std::vector<int>& kinds, int kind) {
  const int across = static_cast<int>(map.values[0].size());
  std::string data;
  for (std::size_t n = 0; n < kinds.size(); ++n)
    if (kinds[n] == kind)
      data += std::to_string(static_cast<int>(n) % across) + " " +
              std::to_string(static_cast<int>(n) / across) + "\n";
  return data;
}

// What is set besides the axes, from the name.
std::string MakeTitle(const StabilityMap& map) {
  std::string title = map.name;
  std::replace(title.begin(), title.end(), '-', ' ');
  return title;
}

}  // namespace

void RenderStabilityMap(const std::string& path, const StabilityMap& map,
                        const std::vector<int>& kinds, const StabilityLine& line) {
  CHECK_EQ(kinds.size(), map.values[0].size() * map.values[1].size());
  std::string script =
      "set encoding utf8\nset terminal pngcairo size 980,640 font 'Sans,12' noenhanced\n"
      "set style fill solid border rgb '#ffffff'\nset tics out nomirror\nset xtics rotate by -45\n"
      "set key outside right top Left reverse spacing 1.3 samplen 1.5\n";
  script += "set title '" + MakeTitle(map) + "'\n" + AxisText("x", map, 0) + AxisText("y", map, 1);
  std::string plot;
  for (int kind = 0; kind < kStabilityClasses; ++kind) {
    const std::string name = "$class" + std::to_string(kind), data = Squares(map, kinds, kind);
    const std::string look = std::string(" fillcolor rgb '") + kColours[kind] + "' title '" +
                             ToString(static_cast<StabilityClass>(kind)) + "'";
    plot += plot.empty() ? "plot " : ", ";
    if (data.empty()) {
      plot += "keyentry with boxes" + look;
      continue;
    }
    script += name + " << END\n" + data + "END\n";
    plot += name + " using 1:2:(0.48):(0.48) with boxxyerror" + look;
  }
  if (!line.x.empty()) {
    script += "$line << END\n";
    for (std::size_t i = 0; i < line.x.size(); ++i)
      script += std::to_string(Position(map.values[0], line.x[i])) + " " +
                std::to_string(Position(map.values[1], line.y[i])) + "\n";
    script += "END\n";
    plot += ", $line with linespoints linecolor rgb '#000000' linewidth 2 pointtype 7 title '" +
            line.title + "'";
  }
  WriteFileAtomically(path, RunGnuplot(script + plot + "\n"));
}

}  // namespace drape
