// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/pattern/pattern_input.h"

#include <nlohmann/json.hpp>
#include <numbers>

#include "physics/util/text_format.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMaxCoordinate = 20;  // [m]
constexpr int kMaxVertices = 1000;

}  // namespace

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

Eigen::Isometry3d ReadPlacement(const JsonInput& panel, double metres) {
  Eigen::Isometry3d placement = Eigen::Isometry3d::Identity();
  if (panel.Has("translation")) {
    const Vector3d shift = metres * panel.At("translation").Vector(3);
    if (shift.cwiseAbs().maxCoeff() > kMaxCoordinate)
      panel.At("translation").Fail(Format("coordinates of at most %g m", kMaxCoordinate));
    placement.translate(shift);
  }
  if (!panel.Has("rotation")) return placement;
  const Vector3d turn = panel.At("rotation").Vector(3) * (std::numbers::pi / 180);
  placement.rotate(Eigen::AngleAxisd(turn.z(), Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(turn.y(), Vector3d::UnitY()) *
                   Eigen::AngleAxisd(turn.x(), Vector3d::UnitX()));
  return placement;
}

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

}  // namespace drape
