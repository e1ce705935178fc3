// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace drape {

// What a picture of numbers shows, and the one writer that renders it (by gnuplot). All texts may
// come from users; none of them is interpreted.

enum class Mark {
  kLine,
  kSteps,  // a value holds until the next point
  kLinePoints,
  kPoints,
  kErrorBars,  // points with bars along x
  kBars,       // upright, from 0
  kSquares,    // of unit size with a white border
  kPolygons    // filled; a point that is not finite separates two
};

enum class Symbol { kDisc, kSquare, kTriangle, kDiamond, kTriangleDown, kPentagon, kRing, kCross };

struct ChartSeries {
  std::string title = {};  // empty: not in the key
  Mark mark = Mark::kLine;
  std::vector<Eigen::Vector2d> points =
      {};  // not finite, or not positive on a logarithmic axis: a gap
  // One for each point or none: half the length of its error bar, otherwise its colour on the
  // colour axis.
  std::vector<double> values = {};
  std::string colour = {};  // "#0072b2"; empty: that of the series' position in the chart
  Symbol symbol = Symbol::kDisc;
  double size = 1.0;   // of symbols
  double width = 2.0;  // of lines
  bool dashed = false;
};

struct ChartAxis {
  std::string label = {};
  bool log = false;
  std::optional<std::pair<double, double>> range = {};  // first value to the left or at the bottom
  // Instead of a range: that of the data, and so much more on both sides, as a share of it.
  double room = 0.0;
  // Instead of marks that the writer chooses; a logarithmic axis with a range or room is marked at
  // round numbers, one without at powers of ten.
  std::optional<std::vector<std::pair<double, std::string>>> ticks = {};
  int tilt = 0;  // of the ticks' texts [degrees]
};

struct ChartLabel {
  enum class Align { kLeft, kCentre, kRight };
  std::string text;
  Eigen::Vector2d at;       // in the units of the axes, or as a share of the picture
  bool in_picture = false;  // the latter
  Align align = Align::kLeft;
  int font_size = 9;
  Eigen::Vector2d offset = {0.0, 0.0};  // from `at` [characters]
};

enum class KeyPlace { kTopRight, kTopLeft, kTop, kBottomRight, kOutside, kNone };

// left, right, bottom, top, as shares of the picture.
struct ChartBox {
  double left, right, bottom, top;
};

struct Chart {
  std::string title = {};
  ChartAxis x = {}, y = {}, colour = {};  // `colour` is shown where a series has colours of it
  std::vector<ChartSeries> series = {};
  std::vector<ChartLabel> labels = {};
  KeyPlace key = KeyPlace::kTopRight;
  std::optional<Eigen::Vector2d> key_at =
      {};                            // instead of `key`: its upper left corner, as a share
  std::optional<ChartBox> box = {};  // of the area between the axes; otherwise it fits the texts
  bool grid = true;
  bool equal_units = false;  // of x and y
};

struct Picture {
  std::string title = {};     // above all charts
  int width = 0, height = 0;  // [px]; 0: 620 × 440 for each chart
  int columns = 2;
  int font_size = 11;
  std::vector<Chart> charts = {};
};

// Writes a PNG, or an SVG where the path ends so; charts are placed row by row, and a series at the
// same position in each chart has the same colour. Beside a PNG, "map.png", it first writes the
// description itself, "map.chart.json", from which drape_report draws the chart. Throws InputError
// when gnuplot is not installed or a file cannot be written.
void WritePicture(const std::string& path, const Picture& picture);

// Calls a function that writes pictures of numbers that are in other files and worth keeping
// without them. A picture that gnuplot does not draw, or is not there to draw, leaves its
// description, and the next one follows. Returns an empty text or, when a picture was not drawn or
// an InputError was thrown, a line that says so: "no pictures: gnuplot: cannot be started, …".
std::string TryPictures(const std::function<void()>& write);

}  // namespace drape
