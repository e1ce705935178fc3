// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "physics/util/text_format.h"
#include "solver/prediction/garment/pattern/pattern.h"

namespace drape {
namespace {

using Eigen::Vector2d;

constexpr int kChords = 48;              // of a curve, in the search for crossings
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
    const int n = straight ? 1 : kChords;
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
