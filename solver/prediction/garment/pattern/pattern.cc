// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/pattern/pattern.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace drape {
namespace {

using Eigen::Vector2d;

constexpr int kLengthChords = 512;

// Of an arc, the centre.
Vector2d ArcCentre(const PatternEdge& edge) {
  const Vector2d half = (edge.end - edge.begin) / 2;
  const double distance = 1 / std::tan(edge.arc_angle / 2);  // in halves of the chord
  return edge.begin + half + distance * Vector2d(-half.y(), half.x());
}

}  // namespace

Vector2d PatternEdge::At(double s) const {
  if (s <= 0) return begin;
  if (s >= 1) return end;
  if (arc_angle != 0) {
    const Vector2d centre = ArcCentre(*this);
    return centre + Eigen::Rotation2Dd(s * arc_angle) * (begin - centre);
  }
  const double r = 1 - s;
  if (control.size() == 2)
    return r * r * r * begin + 3 * s * r * r * control[0] + 3 * s * s * r * control[1] +
           s * s * s * end;
  if (control.size() == 1) return r * r * begin + 2 * s * r * control[0] + s * s * end;
  return r * begin + s * end;
}

double PatternEdge::Length() const {
  double length = 0;
  for (int k = 0; k < kLengthChords; ++k)
    length += (At((k + 1.0) / kLengthChords) - At(double(k) / kLengthChords)).norm();
  return length;
}

std::vector<Vector2d> PatternEdge::Divided(int n) const {
  CHECK_GE(n, 1);
  std::vector<double> length = {0};  // up to each chord
  for (int k = 0; k < kLengthChords; ++k)
    length.push_back(length.back() +
                     (At((k + 1.0) / kLengthChords) - At(double(k) / kLengthChords)).norm());
  std::vector<Vector2d> points = {begin};
  for (int i = 1; i < n; ++i) {
    const double wanted = length.back() * i / n;
    const auto after = std::upper_bound(length.begin() + 1, length.end() - 1, wanted);
    const double share = (wanted - *(after - 1)) / (*after - *(after - 1));
    points.push_back(At((after - 1 - length.begin() + share) / kLengthChords));
  }
  points.push_back(end);
  return points;
}

PatternEdge PatternEdge::Reversed() const {
  return {end, begin, {control.rbegin(), control.rend()}, -arc_angle};
}

PatternEdge MakeArc(const Vector2d& begin, const Vector2d& end, double radius, bool large,
                    bool counter_clockwise) {
  const double sine = std::min(1.0, (end - begin).norm() / (2 * radius));
  const double small = 2 * std::asin(sine);
  const double angle = large ? 2 * std::numbers::pi - small : small;
  return {begin, end, {}, counter_clockwise ? angle : -angle};
}

int Panel::num_edges() const {
  size_t count = outline.size();
  for (const PatternLoop& hole : holes) count += hole.size();
  return static_cast<int>(count);
}

const PatternEdge& Panel::edge(int index) const {
  const PatternLoop* loop = &outline;
  for (size_t hole = 0; index >= static_cast<int>(loop->size()); ++hole) {
    index -= static_cast<int>(loop->size());
    CHECK_LT(hole, holes.size());
    loop = &holes[hole];
  }
  return (*loop)[index];
}

Eigen::Vector3d Panel::Place(const Vector2d& point) const {
  const double r = cylinder_radius;
  if (r <= 0) return placement * Eigen::Vector3d(point.x(), point.y(), 0);
  const double angle = point.x() / r;
  return placement * Eigen::Vector3d(r * std::sin(angle), point.y(), r * std::cos(angle) - r);
}

double LoopArea(const PatternLoop& loop) {
  constexpr int kChords = 32;
  double area = 0;
  for (const PatternEdge& edge : loop) {
    for (int k = 0; k < kChords; ++k) {
      const Vector2d a = edge.At(double(k) / kChords), b = edge.At((k + 1.0) / kChords);
      area += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
  }
  return area;
}

PatternLoop Reversed(const PatternLoop& loop) {
  PatternLoop reversed;
  for (auto edge = loop.rbegin(); edge != loop.rend(); ++edge) reversed.push_back(edge->Reversed());
  return reversed;
}

}  // namespace drape
