// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>
#include <numbers>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/pattern/pattern_input.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

PatternEdge ReadEdge(const JsonInput& input, const Vector2d& begin, const Vector2d& end,
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

Panel ReadPanel(const std::string& name, const JsonInput& input, double metres) {
  Panel panel;
  panel.name = name;
  const auto edge = [&](const JsonInput& e, const Vector2d& begin, const Vector2d& end) {
    return ReadEdge(e, begin, end, metres);
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

}  // namespace

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
  const JsonInput panels = input.At("pattern").At("panels").ExpectObject();
  if (panels.Size() < 1 || panels.Size() > 200) panels.Fail("1 … 200 panels");
  for (const auto& [name, unused] : panels.value().items())
    pattern.panels.push_back(ReadPanel(name, panels.At(name), metres));
  if (!input.At("pattern").Has("stitches")) return pattern;
  const JsonInput stitches = input.At("pattern").At("stitches").ExpectArray();
  for (int k = 0; k < stitches.Size(); ++k)
    pattern.stitches.push_back(ReadGarmentCodeStitch(stitches.At(k), pattern));
  return pattern;
}

}  // namespace drape
