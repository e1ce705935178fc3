// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// Charts of a benchmark, each as PNG and SVG. Throw InputError as WritePicture does.

struct ChartPoint {
  double cost = 0.0;
  double error = 0.0;
  double vertices = 0.0;  // colour
  int series = 0;         // mark
  std::string excluded;   // why it is no part of the front, and grey; empty: it may be
  std::string label;      // in the list of the front
};

struct FrontChart {
  std::string title, cost_name, error_name;  // with units
  std::vector<std::string> series;           // meaning of the marks
  std::vector<ChartPoint> points;            // cost and error above 0
  double reference_error = 0.0;              // drawn as a line; 0: none
};
// Cost against error, log–log, with the Pareto front as a line, its points numbered and listed.
// Writes path.png and path.svg.
void RenderFrontChart(const std::string& path, const FrontChart& chart);

struct GrowthSeries {
  std::string name;
  std::vector<double> vertices, seconds, megabytes;  // of equal size, above 0
};
// Time and memory against vertices, log–log, with the fitted exponents in the legend.
void RenderGrowthChart(const std::string& path, const std::string& title,
                       const std::string& cost_name, const std::vector<GrowthSeries>& series);

// What a drape costs and how far it is off, of one program on one machine.
struct CodeSeries {
  std::string name;
  std::vector<double> vertices = {}, seconds = {}, radius_mm = {};  // of equal size, above 0
};
// Error against time, log–log, a labelled line for each program, and the scatter between samples of
// a fabric as a dashed one. Writes path.png and path.svg.
void RenderCodesChart(const std::string& path, const std::string& cost_name,
                      const std::vector<CodeSeries>& codes);

}  // namespace drape
