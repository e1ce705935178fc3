// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/panel_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "physics/mesh/triangulate.h"
#include "physics/util/errors.h"
#include "physics/util/math/random.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Eigen::Vector2d;
using Segments = std::vector<std::pair<int, int>>;

constexpr int kRelaxationSteps = 100;
// Of a vertex inside from the outline, in edges: a vertex of the outline has a strip of half the
// height of a triangle.
constexpr double kClearance = std::numbers::sqrt3 / 4;

constexpr double kLeastArea = 1e-6;  // of a triangle, in squares of an edge

struct Border {
  std::vector<Vector2d> points;
  Segments segments;
  std::vector<std::vector<int>> edges;
};

Border DivideBorder(const Panel& panel, const std::vector<int>& segments) {
  Border border;
  std::vector<PatternLoop> loops = {panel.outline};
  loops.insert(loops.end(), panel.holes.begin(), panel.holes.end());
  for (const PatternLoop& loop : loops) {
    const int first = static_cast<int>(border.points.size());
    for (const PatternEdge& edge : loop) {
      const auto divided = edge.Divided(segments[border.edges.size()]);
      std::vector<int> vertices(divided.size());
      for (size_t i = 0; i < divided.size(); ++i)
        vertices[i] = static_cast<int>(border.points.size() + i);
      border.points.insert(border.points.end(), divided.begin(), divided.end() - 1);
      border.edges.push_back(std::move(vertices));
    }
    border.edges.back().back() = first;
    const int end = static_cast<int>(border.points.size());
    for (int i = first; i < end; ++i) border.segments.emplace_back(i, i + 1 == end ? first : i + 1);
  }
  return border;
}

// Whether a point is inside the outline and outside the holes.
bool Contains(const Border& border, const Vector2d& point) {
  bool inside = false;
  for (const auto& [i, j] : border.segments) {
    const Vector2d &a = border.points[i], &b = border.points[j];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()) > point.x())
      inside = !inside;
  }
  return inside;
}

double DistanceToBorder(const Border& border, const Vector2d& point) {
  double nearest = HUGE_VAL;
  for (const auto& [i, j] : border.segments) {
    const Vector2d &a = border.points[i], along = border.points[j] - a;
    const double share = std::clamp((point - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (point - a - share * along).squaredNorm());
  }
  return std::sqrt(nearest);
}

// One random point in each square of a grid, as many as equilateral triangles need.
std::vector<Vector2d> ScatterInside(const Border& border, double edge) {
  const double square = edge * std::sqrt(std::numbers::sqrt3 / 2);
  Vector2d low = border.points[0], high = low;
  for (const Vector2d& p : border.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  std::mt19937_64 random(1);
  std::vector<Vector2d> points;
  for (double y = low.y(); y < high.y(); y += square) {
    for (double x = low.x(); x < high.x(); x += square) {
      const double u = .25 + .5 * SampleUniform(random), v = .25 + .5 * SampleUniform(random);
      const Vector2d p(x + u * square, y + v * square);
      if (Contains(border, p) && DistanceToBorder(border, p) > kClearance * edge)
        points.push_back(p);
    }
  }
  return points;
}

// Turns the numbering into that of a space-filling curve.
void Renumber(PanelMesh* mesh) {
  const std::vector<int> order = SpatialOrder(mesh->points);
  std::vector<int> rank(order.size());
  Eigen::Matrix2Xd points(2, mesh->points.cols());
  for (size_t k = 0; k < order.size(); ++k) {
    rank[order[k]] = static_cast<int>(k);
    points.col(k) = mesh->points.col(order[k]);
  }
  mesh->points = std::move(points);
  for (auto& t : mesh->triangles) t = {rank[t[0]], rank[t[1]], rank[t[2]]};
  for (auto& edge : mesh->edges)
    for (int& vertex : edge) vertex = rank[vertex];
}

// Each vertex of the border has a triangle, and each triangle an area.
void CheckMesh(const PanelMesh& mesh, const std::string& name, const std::string& where) {
  std::vector<bool> used(mesh.points.cols(), false);
  for (const auto& t : mesh.triangles)
    for (const int i : t) used[i] = true;
  if (std::find(used.begin(), used.end(), false) != used.end() || mesh.triangles.empty())
    throw InputError(where, "found panel '" + MakePrintableLine(name) +
                                "' too narrow somewhere for triangles of this size, expected "
                                "shorter edges");
}

}  // namespace

PanelMesh MakePanelMesh(const Panel& panel, const std::vector<int>& segments, double edge,
                        const std::string& where) {
  const Border border = DivideBorder(panel, segments);
  const std::vector<Vector2d> inside = ScatterInside(border, edge);
  const int first_inside = static_cast<int>(border.points.size());
  PanelMesh mesh;
  mesh.edges = border.edges;
  mesh.points.resize(2, first_inside + inside.size());
  for (int i = 0; i < first_inside; ++i) mesh.points.col(i) = border.points[i];
  for (size_t i = 0; i < inside.size(); ++i) mesh.points.col(first_inside + i) = inside[i];
  for (int step = 0; step < kRelaxationSteps; ++step)
    MoveToCentroids(Triangulate(mesh.points, border.segments), first_inside, mesh.points);
  for (const auto& t : Triangulate(mesh.points, border.segments)) {
    const Vector2d a = mesh.points.col(t[0]), b = mesh.points.col(t[1]), c = mesh.points.col(t[2]);
    const Vector2d u = b - a, v = c - a;
    // Rounding bends straight edges, so that triangles without area lie along them.
    const bool empty = u.x() * v.y() - u.y() * v.x() < kLeastArea * edge * edge;
    if (!empty && Contains(border, (a + b + c) / 3)) mesh.triangles.push_back(t);
  }
  CheckMesh(mesh, panel.name, where);
  Renumber(&mesh);
  return mesh;
}

}  // namespace drape
