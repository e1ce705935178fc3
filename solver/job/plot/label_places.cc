// SPDX-License-Identifier: Apache-2.0
#include "solver/job/plot/label_places.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace drape {
namespace {

using Box = Eigen::AlignedBox2d;  // [px]

// Of gnuplot's font of 11 pt, by which offsets are measured, and of a label's font [px].
constexpr double kOffsetWidth = 8.5, kOffsetHeight = 17.0;
constexpr double kWidthPerPoint = 0.72, kHeightPerPoint = 1.4;
constexpr double kPointRadius = 4.0;

struct Place {
  ChartLabel::Align align;
  double x, y;  // offset [characters]
};
using Align = ChartLabel::Align;
constexpr Place kPlaces[] = {
    {Align::kLeft, 0.8, 0.5},    {Align::kRight, -0.8, 0.5},  {Align::kLeft, 0.8, -0.5},
    {Align::kRight, -0.8, -0.5}, {Align::kCentre, 0.0, 1.0},  {Align::kCentre, 0.0, -1.0},
    {Align::kLeft, 1.2, 1.3},    {Align::kRight, -1.2, 1.3},  {Align::kLeft, 1.2, -1.3},
    {Align::kRight, -1.2, -1.3}, {Align::kCentre, 0.0, 1.9},  {Align::kCentre, 0.0, -1.9},
    {Align::kLeft, 1.2, 2.1},    {Align::kRight, -1.2, -2.1}, {Align::kLeft, 1.2, -2.1},
    {Align::kRight, -1.2, 2.1}};

Box TextBox(const ChartLabel& label, const Place& place, const Eigen::Vector2d& point) {
  const double width = kWidthPerPoint * label.font_size * double(label.text.size());
  const double height = kHeightPerPoint * label.font_size;
  const Eigen::Vector2d at =
      point + Eigen::Vector2d(kOffsetWidth * place.x, kOffsetHeight * place.y);
  const double left = place.align == Align::kLeft ? 0.0 : place.align == Align::kRight ? 1.0 : 0.5;
  const Eigen::Vector2d low = at - Eigen::Vector2d(left * width, 0.5 * height);
  return {low, low + Eigen::Vector2d(width, height)};
}

double OverlapArea(const Box& text, const std::vector<Box>& taken) {
  double area = 0.0;
  for (const Box& box : taken)
    if (text.intersects(box)) area += std::max(text.intersection(box).volume(), 0.0);
  return area;
}

}  // namespace

void PlaceAround(const Eigen::Vector2d& pixels, std::vector<ChartLabel>* labels) {
  std::vector<Box> taken;
  const Eigen::Vector2d radius = Eigen::Vector2d::Constant(kPointRadius);
  for (const ChartLabel& label : *labels) {
    const Eigen::Vector2d point = label.at.cwiseProduct(pixels);
    taken.push_back({point - radius, point + radius});
  }
  for (ChartLabel& label : *labels) {
    const Eigen::Vector2d point = label.at.cwiseProduct(pixels);
    const Place* best = nullptr;
    double least = 0.0;
    for (const Place& place : kPlaces) {
      const double area = OverlapArea(TextBox(label, place, point), taken);
      if (best != nullptr && area >= least) continue;
      best = &place;
      least = area;
    }
    label.align = best->align;
    label.offset = {best->x, best->y};
    taken.push_back(TextBox(label, *best, point));
  }
}

}  // namespace drape
