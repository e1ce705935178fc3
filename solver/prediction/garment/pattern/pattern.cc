// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/pattern/pattern.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/json_input.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

// What both formats of files have in common.

constexpr double kMaxCoordinate = 20;  // [m]
constexpr int kMaxVertices = 1000, kMaxPanels = 200;
constexpr double kOneDegree = std::numbers::pi / 180;

// Reads points [x, y] of the plane of a panel and multiplies them by `metres` [m].
std::vector<Vector2d> ReadPoints(const JsonInput& input, double metres) {
  if (input.ExpectArray().Size() > kMaxVertices)
    input.Fail(Format("at most %d points", kMaxVertices));
  std::vector<Vector2d> points;
  for (int i = 0; i < input.Size(); ++i) {
    points.emplace_back(metres * input.At(i).Vector(2));
    if (points.back().cwiseAbs().maxCoeff() > kMaxCoordinate)
      input.At(i).Fail(Format("coordinates of at most %g m", kMaxCoordinate));
  }
  return points;
}

// Makes the edge between two points from its entry.
using EdgeReader =
    std::function<PatternEdge(const JsonInput&, const Vector2d& begin, const Vector2d& end)>;

// Reads edges with "endpoints", two indices of vertices. The edges must form one closed loop.
PatternLoop ReadLoop(const JsonInput& edges, const std::vector<Vector2d>& vertices,
                     const EdgeReader& read_edge) {
  const int count = edges.ExpectArray().Size();
  if (count < 2 || count > kMaxVertices) edges.Fail(Format("2 … %d edges", kMaxVertices));
  PatternLoop loop;
  int first = 0, last = 0;  // corners
  for (int k = 0; k < count; ++k) {
    const JsonInput ends = edges.At(k).At("endpoints").ExpectArray(2);
    const int most = static_cast<int>(vertices.size()) - 1;
    const int begin = ends.At(0).IntegerWithin(0, most), end = ends.At(1).IntegerWithin(0, most);
    if (vertices[begin] == vertices[end]) ends.Fail("two different points");
    if (k == 0) first = begin;
    if (k > 0 && begin != last) ends.At(0).Fail(Format("%d, where the edge before it ends", last));
    if (k == count - 1 && end != first)
      ends.At(1).Fail(Format("%d, where the loop begins, so that it is closed", first));
    loop.push_back(read_edge(edges.At(k), vertices[begin], vertices[end]));
    last = end;
  }
  return loop;
}

// Reads "translation" [x, y, z], times `metres`, and "rotation" about the fixed axes x, y, z in
// this order [degrees]. Both may be absent.
Eigen::Isometry3d ReadPlacement(const JsonInput& panel, double metres) {
  Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
  if (panel.Has("translation")) {
    const Vector3d shift = metres * panel.At("translation").Vector(3);
    if (shift.cwiseAbs().maxCoeff() > kMaxCoordinate)
      panel.At("translation").Fail(Format("coordinates of at most %g m", kMaxCoordinate));
    placement.translate(shift);
  }
  if (!panel.Has("rotation")) return placement;
  const Vector3d turn = kOneDegree * panel.At("rotation").Vector(3);
  placement.rotate(Eigen::AngleAxisd(turn.z(), Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(turn.y(), Vector3d::UnitY()) *
                   Eigen::AngleAxisd(turn.x(), Vector3d::UnitX()));
  return placement;
}

// Finds a panel by its name.
int ReadPanelName(const JsonInput& name, const Pattern& pattern) {
  const std::string wanted = name.String();
  std::string names;
  for (size_t i = 0; i < pattern.panels.size(); ++i) {
    if (pattern.panels[i].name == wanted) return static_cast<int>(i);
    names += (i == 0 ? "" : ", ") + pattern.panels[i].name;
  }
  name.Fail("the name of a panel: " + names);
}

PanelEdge ReadPanelEdge(const JsonInput& name, const JsonInput& edge, const Pattern& pattern) {
  const int panel = ReadPanelName(name, pattern);
  return {panel, edge.IntegerWithin(0, pattern.panels[panel].num_edges() - 1)};
}

// Reads the panels of an object by their names.
void ReadPanels(const JsonInput& panels,
                const std::function<Panel(const std::string& name, const JsonInput& input)>& read,
                Pattern* pattern) {
  if (panels.ExpectObject().Size() < 1 || panels.Size() > kMaxPanels)
    panels.Fail(Format("1 … %d panels", kMaxPanels));
  for (const auto& [name, unused] : panels.value().items())
    pattern->panels.push_back(read(name, panels.At(name)));
}

// Our own format.

constexpr char kGarmentFormat[] = "drapefit-garment";
constexpr int kGarmentVersion = 1;
constexpr double kLeastArm = 25, kMostArm = 90;  // [degrees]

PatternEdge ReadOwnEdge(const JsonInput& input, const Vector2d& begin, const Vector2d& end) {
  input.ExpectKeys({"endpoints", "quadratic", "cubic", "circle"});
  if (input.Has("quadratic") + input.Has("cubic") + input.Has("circle") > 1)
    input.Fail("one of quadratic, cubic and circle");
  if (input.Has("quadratic"))
    return {begin, end, ReadPoints(input.At("quadratic").ExpectArray(1), 1)};
  if (input.Has("cubic")) return {begin, end, ReadPoints(input.At("cubic").ExpectArray(2), 1)};
  if (!input.Has("circle")) return {begin, end};
  const JsonInput circle = input.At("circle");
  circle.ExpectKeys({"radius", "large", "counter_clockwise"});
  const double radius = circle.At("radius").NumberWithin(1e-3, 100);
  // The tolerance of half circles whose radius was rounded.
  if (radius < .4999 * (end - begin).norm())
    circle.At("radius").Fail(
        Format("at least half the distance of the endpoints, %.6g m", (end - begin).norm() / 2));
  return MakeArc(begin, end, radius, circle.Has("large") && circle.At("large").Boolean(),
                 circle.At("counter_clockwise").Boolean());
}

Panel ReadPanel(const std::string& name, const JsonInput& input) {
  input.ExpectKeys({"vertices", "outline", "holes", "translation", "rotation", "cylinder_radius"});
  Panel panel;
  panel.name = name;
  const std::vector<Vector2d> vertices = ReadPoints(input.At("vertices"), 1);
  panel.outline = ReadLoop(input.At("outline"), vertices, ReadOwnEdge);
  if (LoopArea(panel.outline) <= 0) input.At("outline").Fail("a counter-clockwise outline");
  if (input.Has("holes")) {
    const JsonInput holes = input.At("holes").ExpectArray();
    for (int k = 0; k < holes.Size(); ++k) {
      panel.holes.push_back(ReadLoop(holes.At(k), vertices, ReadOwnEdge));
      if (LoopArea(panel.holes.back()) >= 0) holes.At(k).Fail("a clockwise hole");
    }
  }
  panel.placement = ReadPlacement(input, 1);
  if (input.Has("cylinder_radius"))
    panel.cylinder_radius = input.At("cylinder_radius").NumberWithin(1e-3, 100);
  return panel;
}

Stitch ReadStitch(const JsonInput& input, const Pattern& pattern) {
  input.ExpectKeys({"edges", "same_direction", "ease"});
  const JsonInput edges = input.At("edges").ExpectArray(2);
  const auto edge = [&](int k) {
    const JsonInput pair = edges.At(k).ExpectArray(2);
    return ReadPanelEdge(pair.At(0), pair.At(1), pattern);
  };
  const auto flag = [&](const char* key) { return input.Has(key) && input.At(key).Boolean(); };
  return {edge(0), edge(1), flag("same_direction"), flag("ease")};
}

Ring ReadRing(const JsonInput& input, const Pattern& pattern) {
  input.ExpectKeys({"name", "panel", "edges", "held_by"});
  Ring ring;
  ring.name = input.At("name").String();
  ring.panel = ReadPanelName(input.At("panel"), pattern);
  const JsonInput edges = input.At("edges").ExpectArray();
  for (int k = 0; k < edges.Size(); ++k)
    ring.edges.push_back(edges.At(k).IntegerWithin(0, pattern.panels[ring.panel].num_edges() - 1));
  if (input.Has("held_by")) {
    if (input.At("held_by").String() != "pelvis") input.At("held_by").Fail("\"pelvis\"");
    ring.held_by_pelvis = true;
  }
  return ring;
}

Pattern ReadOwnFormat(const JsonInput& input) {
  input.ExpectKeys({"format", "version", "name", "arm_angle", "panels", "stitches", "rings"});
  if (input.At("format").String() != kGarmentFormat)
    input.At("format").Fail(std::string("\"").append(kGarmentFormat) + '"');
  if (input.At("version").Integer() != kGarmentVersion) input.At("version").Fail("1");
  Pattern pattern;
  if (input.Has("name")) pattern.name = input.At("name").String();
  if (input.Has("arm_angle"))
    pattern.arm_angle = input.At("arm_angle").NumberWithin(kLeastArm, kMostArm) * kOneDegree;
  ReadPanels(input.At("panels"), ReadPanel, &pattern);
  const auto each = [&](const char* key, const auto& read) {
    if (!input.Has(key)) return;
    const JsonInput list = input.At(key).ExpectArray();
    for (int k = 0; k < list.Size(); ++k) read(list.At(k));
  };
  each("stitches",
       [&](const JsonInput& item) { pattern.stitches.push_back(ReadStitch(item, pattern)); });
  each("rings", [&](const JsonInput& item) { pattern.rings.push_back(ReadRing(item, pattern)); });
  return pattern;
}

// The format of GarmentCode.

// A point in the coordinates of an edge: along it and to its left, in units of its length.
Vector2d FromEdgeCoordinates(const JsonInput& input, const Vector2d& begin, const Vector2d& end) {
  const Vector2d share = input.Vector(2), along = end - begin;
  return begin + share.x() * along + share.y() * Vector2d(-along.y(), along.x());
}

constexpr double kMostRadius = 1e4;  // [m]; beyond it points of an arc are lost to rounding

PatternEdge ReadArc(const JsonInput& params, const Vector2d& begin, const Vector2d& end,
                    double metres) {
  params.ExpectArray(3);
  // The two flags are written as numbers or as Booleans.
  const auto flag = [&](int k) {
    const JsonInput input = params.At(k);
    return input.value().is_boolean() ? input.Boolean() : input.IntegerWithin(0, 1) != 0;
  };
  const double radius = params.At(0).Number() * metres;
  if (!(radius > 0 && radius <= kMostRadius))
    params.At(0).Fail(Format("a radius > 0 of at most %g m", kMostRadius));
  return MakeArc(begin, end, radius, flag(1), flag(2));
}

PatternEdge ReadGarmentCodeEdge(const JsonInput& input, const Vector2d& begin, const Vector2d& end,
                                double metres) {
  if (!input.Has("curvature")) return {begin, end};
  const JsonInput curvature = input.At("curvature");
  const auto point = [&](const JsonInput& p) { return FromEdgeCoordinates(p, begin, end); };
  if (curvature.value().is_array()) return {begin, end, {point(curvature)}};
  const std::string type = curvature.At("type").String();
  const JsonInput params = curvature.At("params");
  if (type == "quadratic") return {begin, end, {point(params.ExpectArray(1).At(0))}};
  if (type == "cubic")
    return {begin, end, {point(params.ExpectArray(2).At(0)), point(params.At(1))}};
  if (type == "circle") return ReadArc(params, begin, end, metres);
  curvature.At("type").Fail("\"quadratic\", \"cubic\" or \"circle\"");
}

// Turns a panel over whose outline is clockwise: its outer side is where the outline is
// counter-clockwise.
void TurnOver(Panel* panel) {
  const auto mirror = [](Vector2d& p) { p.x() = -p.x(); };
  for (PatternEdge& edge : panel->outline) {
    mirror(edge.begin);
    mirror(edge.end);
    for (Vector2d& p : edge.control) mirror(p);
    edge.arc_angle = -edge.arc_angle;
  }
  panel->placement.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitY()));
}

Panel ReadGarmentCodePanel(const std::string& name, const JsonInput& input, double metres) {
  Panel panel;
  panel.name = name;
  const auto edge = [&](const JsonInput& e, const Vector2d& begin, const Vector2d& end) {
    return ReadGarmentCodeEdge(e, begin, end, metres);
  };
  panel.outline = ReadLoop(input.At("edges"), ReadPoints(input.At("vertices"), metres), edge);
  // From y up, facing +z, to z up, facing −y.
  panel.placement =
      Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX()) * ReadPlacement(input, metres);
  const double area = LoopArea(panel.outline);
  if (area == 0) input.At("edges").Fail("an outline with an area");
  if (area < 0) TurnOver(&panel);
  return panel;
}

Stitch ReadGarmentCodeStitch(const JsonInput& input, const Pattern& pattern) {
  const int size = input.ExpectArray().Size();
  if (size < 2 || size > 3) input.Fail("two edges and, optionally, \"right_wrong\"");
  const auto edge = [&](int k) {
    return ReadPanelEdge(input.At(k).At("panel"), input.At(k).At("edge"), pattern);
  };
  Stitch stitch{edge(0), edge(1), false, /*ease=*/true};
  if (size == 3) {
    if (input.At(2).String() != "right_wrong") input.At(2).Fail("\"right_wrong\"");
    stitch.same_direction = true;
  }
  return stitch;
}

Pattern ReadGarmentCode(const JsonInput& input) {
  double metres = .01;
  if (input.Has("properties")) {
    const JsonInput properties = input.At("properties");
    if (properties.Has("units_in_meter"))
      metres = 1 / properties.At("units_in_meter").NumberWithin(.01, 1e4);
    if (properties.Has("curvature_coords") &&
        properties.At("curvature_coords").String() != "relative")
      properties.At("curvature_coords").Fail("\"relative\"");
  }
  Pattern pattern;
  ReadPanels(
      input.At("pattern").At("panels"),
      [&](const std::string& name, const JsonInput& panel) {
        return ReadGarmentCodePanel(name, panel, metres);
      },
      &pattern);
  if (!input.At("pattern").Has("stitches")) return pattern;
  const JsonInput stitches = input.At("pattern").At("stitches").ExpectArray();
  for (int k = 0; k < stitches.Size(); ++k)
    pattern.stitches.push_back(ReadGarmentCodeStitch(stitches.At(k), pattern));
  return pattern;
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
  if (r <= 0) return placement * Vector3d(point.x(), point.y(), 0);
  const double angle = point.x() / r;
  return placement * Vector3d(r * std::sin(angle), point.y(), r * std::cos(angle) - r);
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

Pattern ReadPattern(const std::string& path) {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (!input.Has("format") && !input.Has("pattern"))
    input.Fail("a garment (keys format, version, panels) or a GarmentCode pattern (key pattern)");
  Pattern pattern = input.Has("format") ? ReadOwnFormat(input) : ReadGarmentCode(input);
  const PatternProblem problem = FindProblem(pattern);
  if (!problem.key.empty()) {
    const std::string prefix = input.Has("format") ? "" : "pattern.";
    throw InputError(path, "key '" + prefix + problem.key + "': found " + problem.found +
                               ", expected " + problem.expected);
  }
  return pattern;
}

}  // namespace drape
