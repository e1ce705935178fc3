// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/pattern/pattern.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "physics/util/text_format.h"

namespace drape {
namespace {

using Eigen::Vector2d;

constexpr int kLengthChords = 512;

// The centre of an arc.
Vector2d ArcCentre(const PatternEdge& edge) {
  const Vector2d half = (edge.end - edge.begin) / 2;
  const double distance = 1 / std::tan(edge.arc_angle / 2);  // in halves of the chord
  return edge.begin + half + distance * Vector2d(-half.y(), half.x());
}

constexpr int kCrossingChords = 48;      // of a curve, in the search for crossings
constexpr double kMaxDifference = 0.05;  // of the lengths of a seam

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

struct Chord {
  Vector2d a, b;
  int edge;
  int number;  // along its loop
  int loop;
};

bool Touch(const Chord& p, const Chord& q) {
  const auto side = [](const Chord& c, const Vector2d& v) { return Cross(c.b - c.a, v - c.a); };
  const double pa = side(q, p.a), pb = side(q, p.b), qa = side(p, q.a), qb = side(p, q.b);
  if (pa == 0 && pb == 0) {  // on one line
    const Vector2d low = p.a.cwiseMin(p.b), high = p.a.cwiseMax(p.b);
    return (q.a.cwiseMax(q.b).array() >= low.array()).all() &&
           (q.a.cwiseMin(q.b).array() <= high.array()).all();
  }
  return pa * pb <= 0 && qa * qb <= 0;
}

// Chords that follow one another meet in a point, and cross only if the second turns back.
bool TurnsBack(const Chord& p, const Chord& q) {
  const Vector2d u = p.b - p.a, v = q.b - q.a;
  return u.dot(v) < 0 && std::abs(Cross(u, v)) <= 1e-9 * u.norm() * v.norm();
}

std::vector<Chord> LoopChords(const PatternLoop& loop, int first_edge, int number) {
  std::vector<Chord> chords;
  for (size_t e = 0; e < loop.size(); ++e) {
    const bool straight = loop[e].control.empty() && loop[e].arc_angle == 0;
    const int n = straight ? 1 : kCrossingChords;
    for (int k = 0; k < n; ++k)
      chords.push_back({loop[e].At(double(k) / n), loop[e].At((k + 1.0) / n),
                        first_edge + static_cast<int>(e), static_cast<int>(chords.size()), number});
  }
  return chords;
}

struct PanelChords {
  std::vector<Chord> all;
  std::vector<int> loop_size;
};

PanelChords MakeChords(const Panel& panel) {
  PanelChords chords{LoopChords(panel.outline, 0, 0), {}};
  chords.loop_size.push_back(static_cast<int>(chords.all.size()));
  int first = static_cast<int>(panel.outline.size());
  for (const PatternLoop& hole : panel.holes) {
    const auto more = LoopChords(hole, first, static_cast<int>(chords.loop_size.size()));
    first += static_cast<int>(hole.size());
    chords.loop_size.push_back(static_cast<int>(more.size()));
    chords.all.insert(chords.all.end(), more.begin(), more.end());
  }
  return chords;
}

bool ChordsCross(const Chord& p, const Chord& q, const std::vector<int>& loop_size) {
  if (p.loop == q.loop) {
    const int n = loop_size[p.loop];
    if ((p.number + 1) % n == q.number) return TurnsBack(p, q);
    if ((q.number + 1) % n == p.number) return TurnsBack(q, p);
  }
  return Touch(p, q);
}

PatternProblem FindCrossing(const Panel& panel, const std::string& key) {
  const PanelChords chords = MakeChords(panel);
  for (size_t i = 0; i < chords.all.size(); ++i) {
    for (size_t j = i + 1; j < chords.all.size(); ++j) {
      const Chord &p = chords.all[i], &q = chords.all[j];
      if (!ChordsCross(p, q, chords.loop_size)) continue;
      const Vector2d place = (p.a + p.b) / 2;
      return {key,
              Format("edges %d and %d, which cross or touch near (%.4g, %.4g) m", p.edge, q.edge,
                     place.x(), place.y()),
              "edges that meet at corners only"};
    }
  }
  return {};
}

bool Contains(const PatternLoop& loop, const Vector2d& point) {
  bool inside = false;
  for (const Chord& c : LoopChords(loop, 0, 0)) {
    if ((c.a.y() > point.y()) == (c.b.y() > point.y())) continue;
    const double x = c.a.x() + (point.y() - c.a.y()) / (c.b.y() - c.a.y()) * (c.b.x() - c.a.x());
    if (x > point.x()) inside = !inside;
  }
  return inside;
}

PatternProblem FindPanelProblem(const Panel& panel) {
  const std::string key = "panels." + panel.name;
  if (PatternProblem crossing = FindCrossing(panel, key); !crossing.key.empty()) return crossing;
  for (const PatternLoop& hole : panel.holes) {
    if (!Contains(panel.outline, hole[0].begin))
      return {key, "a hole outside the outline", "holes inside it"};
    for (const PatternLoop& other : panel.holes)
      if (&other != &hole && Contains(other, hole[0].begin))
        return {key, "a hole inside another hole", "holes apart from one another"};
  }
  const double widest = std::numbers::pi * panel.cylinder_radius;
  for (const Chord& chord : LoopChords(panel.outline, 0, 0)) {
    if (panel.cylinder_radius > 0 && std::abs(chord.a.x()) >= widest)
      return {key + ".cylinder_radius", Format("%g m", panel.cylinder_radius),
              Format("more than |x|/π, here %g m, so that the panel does not overlap itself",
                     std::abs(chord.a.x()) / std::numbers::pi)};
  }
  return {};
}

PatternProblem FindStitchProblem(const Pattern& pattern, const Stitch& stitch,
                                 const std::string& key) {
  const auto name = [&](const PanelEdge& e) {
    return "edge " + std::to_string(e.edge) + " of '" + pattern.panels[e.panel].name + "'";
  };
  const auto length = [&](const PanelEdge& e) {
    return pattern.panels[e.panel].edge(e.edge).Length();
  };
  const double first = length(stitch.first), second = length(stitch.second);
  if (!stitch.ease && std::abs(first - second) > kMaxDifference * std::max(first, second))
    return {key,
            name(stitch.first) + Format(" of %.4g m and ", first) + name(stitch.second) +
                Format(" of %.4g m", second),
            "lengths that differ by at most 5 %, or \"ease\": true"};
  return {};
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

PatternProblem FindProblem(const Pattern& pattern) {
  for (const Panel& panel : pattern.panels)
    if (PatternProblem problem = FindPanelProblem(panel); !problem.key.empty()) return problem;
  std::set<std::pair<int, int>> sewn;
  for (size_t k = 0; k < pattern.stitches.size(); ++k) {
    const std::string key = "stitches[" + std::to_string(k) + "]";
    for (const PanelEdge& e : {pattern.stitches[k].first, pattern.stitches[k].second})
      if (!sewn.emplace(e.panel, e.edge).second)
        return {key,
                "edge " + std::to_string(e.edge) + " of '" + pattern.panels[e.panel].name +
                    "' a second time",
                "each edge in one seam at most"};
    if (PatternProblem problem = FindStitchProblem(pattern, pattern.stitches[k], key);
        !problem.key.empty())
      return problem;
  }
  return {};
}

}  // namespace drape
