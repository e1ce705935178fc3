// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/pattern/pattern.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/pattern/pattern_input.h"

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

using Eigen::Vector2d;

constexpr char kGarmentFormat[] = "drapefit-garment";
constexpr int kVersion = 1, kMaxPanels = 200;
constexpr double kDegree = std::numbers::pi / 180;
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
  if (input.At("version").Integer() != kVersion) input.At("version").Fail("1");
  Pattern pattern;
  if (input.Has("name")) pattern.name = input.At("name").String();
  if (input.Has("arm_angle"))
    pattern.arm_angle = input.At("arm_angle").NumberWithin(kLeastArm, kMostArm) * kDegree;
  const JsonInput panels = input.At("panels").ExpectObject();
  if (panels.Size() < 1 || panels.Size() > kMaxPanels)
    panels.Fail(Format("1 … %d panels", kMaxPanels));
  for (const auto& [name, unused] : panels.value().items())
    pattern.panels.push_back(ReadPanel(name, panels.At(name)));
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

Pattern ReadPattern(const std::string& path) {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (!input.Has("format") && !input.Has("pattern"))
    input.Fail("a garment (keys format, version, panels) or a GarmentCode pattern (key pattern)");
  Pattern pattern = input.Has("format") ? ReadOwnFormat(input) : ReadGarmentCode(input);
  if (pattern.arm_angle == 0) pattern.arm_angle = kLeastArm * kDegree;
  const PatternProblem problem = FindProblem(pattern);
  if (!problem.key.empty()) {
    const std::string prefix = input.Has("format") ? "" : "pattern.";
    throw InputError(path, "key '" + prefix + problem.key + "': found " + problem.found +
                               ", expected " + problem.expected);
  }
  return pattern;
}

}  // namespace drape
