// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/space_picture.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "physics/util/text_format.h"
#include "solver/job/plot/chart.h"
#include "solver/job/plot/label_places.h"

namespace drape {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
constexpr char kBlue[] = "#0072b2", kRed[] = "#d55e00", kGrey[] = "#b0b0b0";
constexpr double kCentimetre = 0.01;

// One standard deviation about a point, as a closed curve.
std::vector<Eigen::Vector2d> Ellipse(const Eigen::Vector2d& centre,
                                     const Eigen::Matrix2d& covariance) {
  constexpr int kPoints = 72;
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    points.emplace_back(centre + root * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

ChartSeries OutlineSeries(std::vector<Eigen::Vector2d> points, const char* colour) {
  return {.mark = Mark::kLine, .points = std::move(points), .colour = colour, .width = 1.0};
}

ChartLabel NameAt(const std::string& name, const Eigen::Vector2d& at) {
  return {.text = name, .at = at};
}

// The side of the area between the axes of a map [px], about.
constexpr double kMapSide = 700.0;

// Of the longer side of the box around all series.
double LargestExtent(const Chart& chart) {
  Eigen::AlignedBox2d box;
  for (const ChartSeries& series : chart.series)
    for (const Eigen::Vector2d& at : series.points) box.extend(at);
  return box.sizes().maxCoeff();
}

// Where each cluster of the tree is: height, and place among the leaves.
std::vector<Eigen::Vector2d> ClusterPlaces(const MaterialSpace& space,
                                           const std::vector<int>& order) {
  std::vector<Eigen::Vector2d> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) places[order[i]] = {0.0, double(i)};
  for (const ClusterMerge& merge : space.tree)
    places.emplace_back(merge.height, 0.5 * (places[merge.left].y() + places[merge.right].y()));
  return places;
}

Chart TreeChart(const MaterialSpace& space, const std::vector<int>& order, const ChartBox& box) {
  const double count = double(order.size());
  const std::vector<Eigen::Vector2d> places = ClusterPlaces(space, order);
  ChartSeries lines{.mark = Mark::kLine, .points = {}, .colour = "#000000", .width = 1.5};
  for (std::size_t k = 0; k < space.tree.size(); ++k) {
    const ClusterMerge& merge = space.tree[k];
    const Eigen::Vector2d &left = places[merge.left], &right = places[merge.right];
    for (const Eigen::Vector2d& at : {left, Eigen::Vector2d(merge.height, left.y()),
                                      Eigen::Vector2d(merge.height, right.y()), right})
      lines.points.push_back(at);
    lines.points.emplace_back(kGap, kGap);
  }
  const double top = space.tree.empty() ? 1.0 : space.tree.back().height;
  return {.x = {.label = "W2 of the branches [log units]", .range = {{1.05 * top, 0.0}}},
          .y = {.range = {{count - 0.5, -0.5}}, .ticks = {{{0.0, ""}}}},
          .series = {lines},
          .key = KeyPlace::kNone,
          .box = box};
}

// The Hellinger metric; no number where the data of the pair determine no direction in common.
Eigen::MatrixXd KnownDistances(const MaterialSpace& space) {
  Eigen::MatrixXd known = space.hellinger;
  for (const PairDistances& pair : space.pairs)
    if (pair.directions == 0)
      known(pair.first, pair.second) = known(pair.second, pair.first) = kGap;
  return known;
}

Chart CellsChart(const MaterialSpace& space, const std::vector<int>& order, const ChartBox& box) {
  const double count = double(order.size());
  const Eigen::MatrixXd known = KnownDistances(space);
  ChartSeries cells{.mark = Mark::kPolygons};
  ChartAxis names{.range = {{count - 0.5, -0.5}}};
  names.ticks.emplace();
  for (std::size_t i = 0; i < order.size(); ++i) {
    names.ticks->emplace_back(double(i), space.beliefs.fabrics[order[i]].name);
    for (std::size_t j = 0; j < order.size(); ++j) {
      const double x = double(j), y = double(i), value = known(order[i], order[j]);
      for (const Eigen::Vector2d& at :
           {Eigen::Vector2d(x - 0.5, y - 0.5), Eigen::Vector2d(x + 0.5, y - 0.5),
            Eigen::Vector2d(x + 0.5, y + 0.5), Eigen::Vector2d(x - 0.5, y + 0.5)}) {
        cells.points.push_back(at);
        cells.values.push_back(value);
      }
      cells.points.emplace_back(kGap, kGap);
      cells.values.push_back(kGap);
    }
  }
  ChartAxis below = names;
  below.range = {{-0.5, count - 0.5}};
  below.tilt = -60;
  return {.x = below,
          .y = names,
          .colour = {.label = "Hellinger metric of specimens", .range = {{0.0, 1.0}}},
          .series = {cells},
          .key = KeyPlace::kNone,
          .box = box,
          .grid = false};
}

}  // namespace

void RenderHeatMap(const std::string& path, const MaterialSpace& space) {
  const std::vector<int> order = LeafOrder(space.tree);
  constexpr double kBottom = 0.2, kTop = 0.95;
  const Picture picture{.width = 1100,
                        .height = 720,
                        .columns = 2,
                        .charts = {TreeChart(space, order, {0.04, 0.24, kBottom, kTop}),
                                   CellsChart(space, order, {0.40, 0.86, kBottom, kTop})}};
  WritePicture(path, picture);
}

void RenderSpaceMap(const std::string& path, const MaterialSpace& space) {
  Chart chart{.x = {.label = "first axis [log units]", .room = 0.2},
              .y = {.label = "second axis [log units]", .room = 0.2},
              .key = KeyPlace::kNone,
              .equal_units = true};
  ChartSeries points{.mark = Mark::kPoints, .colour = kBlue},
      added{.mark = Mark::kPoints, .colour = kRed, .symbol = Symbol::kDiamond, .size = 2.0};
  for (std::size_t i = 0; i < space.beliefs.fabrics.size(); ++i) {
    const Eigen::Vector2d at = space.map.points.row(Eigen::Index(i));
    points.points.push_back(at);
    chart.series.push_back(OutlineSeries(Ellipse(at, space.map.ellipses[i]), kGrey));
    chart.labels.push_back(NameAt(space.beliefs.fabrics[i].name, at));
  }
  for (const JudgedMaterial& material : space.added) {
    added.points.push_back(material.at);
    chart.labels.push_back(NameAt(material.name, material.at));
  }
  chart.series.push_back(points);
  chart.series.push_back(added);
  const double extent = LargestExtent(chart) * (1.0 + 2.0 * chart.x.room);
  PlaceAround(Eigen::Vector2d::Constant(kMapSide / extent), &chart.labels);
  WritePicture(path, {.width = 900, .height = 760, .charts = {chart}});
}

void RenderTextileMap(const std::string& path, const MaterialSpace& space,
                      const std::vector<FabricBelief>& added) {
  Chart chart{.x = {.label = "bending length along the weft [cm]"},
              .y = {.label = "bending length along the warp [cm]"},
              .key = KeyPlace::kNone,
              .equal_units = true};
  ChartSeries points{.mark = Mark::kPoints, .colour = kBlue},
      further{.mark = Mark::kPoints, .colour = kRed, .symbol = Symbol::kDiamond, .size = 2.0};
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  const auto add = [&](const FabricBelief& fabric, ChartSeries* series) {
    const NormalDistribution lengths = LogBendingLengths(space.beliefs.frame, fabric);
    std::vector<Eigen::Vector2d> outline = Ellipse(lengths.mean, lengths.covariance);
    for (Eigen::Vector2d& at : outline) {
      at = at.array().exp() / kCentimetre;
      least = std::min(least, at.minCoeff());
      most = std::max(most, at.maxCoeff());
    }
    const Eigen::Vector2d centre = lengths.mean.array().exp() / kCentimetre;
    series->points.push_back(centre);
    chart.series.push_back(OutlineSeries(outline, kGrey));
    chart.labels.push_back(NameAt(fabric.name, centre));
  };
  for (const FabricBelief& fabric : space.beliefs.fabrics) add(fabric, &points);
  for (const FabricBelief& fabric : added) add(fabric, &further);
  least *= 0.9;
  most *= 1.1;
  PlaceAround(Eigen::Vector2d::Constant(kMapSide / (most - least)), &chart.labels);
  for (int tenth = 1; tenth <= 9; ++tenth) {
    const double dc = 0.1 * tenth, mean = IsotropicBendingLength(dc) / kCentimetre;
    ChartSeries curve{.mark = Mark::kLine, .colour = "#009e73", .width = 0.8, .dashed = true};
    constexpr int kPoints = 80;
    for (int i = 0; i <= kPoints; ++i) {
      const double x = least * std::pow(most / least, double(i) / kPoints), y = mean * mean / x;
      if (y >= least && y <= most) curve.points.emplace_back(x, y);
    }
    if (curve.points.empty()) continue;
    chart.labels.push_back({.text = Format("DC %.1f", dc),
                            .at = curve.points.front(),
                            .font_size = 8,
                            .offset = {0.5, -0.5}});
    chart.series.push_back(curve);
  }
  chart.x.range = chart.y.range = {{least, most}};
  chart.series.push_back(points);
  chart.series.push_back(further);
  WritePicture(path, {.width = 900, .height = 860, .charts = {chart}});
}

namespace {

struct DrapeRow {
  double bending_length, drape_coefficient;  // [m]
};
// Means of 12 drapes each; below the first row linear to zero.
constexpr DrapeRow kIsotropicDrapes[] = {
    {0.0, 0.0},      {0.0080, 0.267}, {0.0100, 0.319}, {0.0125, 0.398},
    {0.0150, 0.481}, {0.0175, 0.566}, {0.0200, 0.652}, {0.0225, 0.725},
    {0.0250, 0.780}, {0.0275, 0.816}, {0.0300, 0.855}, {0.0350, 0.912},
    {0.0400, 0.949}, {0.0450, 0.971}, {0.0500, 0.981}, {0.0600, 0.987}};

}  // namespace

double IsotropicDrapeCoefficient(double bending_length) {
  const auto* const rows = kIsotropicDrapes;
  const int count = static_cast<int>(std::size(kIsotropicDrapes));
  int k = 1;
  while (k + 1 < count && rows[k].bending_length < bending_length) ++k;
  const double from = rows[k - 1].bending_length, to = rows[k].bending_length;
  const double share = std::clamp((bending_length - from) / (to - from), 0.0, 1.0);
  return std::lerp(rows[k - 1].drape_coefficient, rows[k].drape_coefficient, share);
}

double IsotropicBendingLength(double drape_coefficient) {
  double low = 1e-3, high = 0.1;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (IsotropicDrapeCoefficient(middle) < drape_coefficient ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace drape
