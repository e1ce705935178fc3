// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

namespace drape {

// A line of a chart. Points that are not finite, or not positive on a logarithmic axis, are gaps.
struct ChartLine {
  std::string title;  // empty: not in the key
  std::vector<Eigen::Vector2d> points;
  bool marked = false;  // points as well as the line
};

struct Chart {
  std::string title = {}, x_label = {}, y_label = {};
  bool log_x = false, log_y = false;
  bool steps = false;           // values hold until the next point
  std::string y_range = "*:*";  // of gnuplot, "0:1"
  std::string key = "top right";
  std::vector<ChartLine> lines = {};
};

// Writes a PNG with the charts side by side, `columns` in a row; a method or law that stands at the
// same place in each chart has the same colour. Throws InputError when gnuplot is not there.
void RenderCharts(const std::string& path, const std::vector<Chart>& charts, int columns = 2);

// Bars with values 0 … 1, one a name.
void DrawShares(const std::string& path, const std::string& title,
                const std::vector<std::pair<std::string, double>>& shares);

}  // namespace drape
