// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/garment_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
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
// The distance of an inner vertex from the outline, in edges: a vertex of the outline has a strip
// of half the height of a triangle.
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

struct PanelMesh {
  Eigen::Matrix2Xd points;                    // [m], shape [2, V]
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise
  std::vector<std::vector<int>> edges;        // the vertices of each edge, both ends included
};

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

// One panel with segments[e] equal segments on edge e and triangle edges of about `edge` [m]
// inside. Throws InputError that names `where` and the panel when they are too long for it.
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

constexpr double kLeastEdge = .002, kMostEdge = .1;  // [m]
constexpr double kMostVertices = 1e6;
constexpr double kPanelGap = .05;  // [m]

// Numbers all edges of a pattern in one list.
class EdgeList {
 public:
  explicit EdgeList(const Pattern& pattern) : first_{0} {
    for (const Panel& panel : pattern.panels) first_.push_back(first_.back() + panel.num_edges());
  }
  int Index(const PanelEdge& e) const { return first_[e.panel] + e.edge; }
  int first(int panel) const { return first_[panel]; }
  int size() const { return first_.back(); }

 private:
  std::vector<int> first_;
};

// The number of segments of each edge: a seam has one number for both of its sides.
std::vector<int> CountSegments(const Pattern& pattern, const EdgeList& list, double edge) {
  std::vector<int> count(list.size());
  for (size_t p = 0; p < pattern.panels.size(); ++p) {
    const Panel& panel = pattern.panels[p];
    const int least = panel.outline.size() == 2 ? 2 : 1;
    for (int e = 0; e < panel.num_edges(); ++e)
      count[list.first(p) + e] =
          std::max(least, static_cast<int>(std::lround(panel.edge(e).Length() / edge)));
    for (const PatternLoop& hole : panel.holes)
      if (hole.size() == 2)
        for (int e = static_cast<int>(panel.outline.size()); e < panel.num_edges(); ++e)
          count[list.first(p) + e] = std::max(2, count[list.first(p) + e]);
  }
  for (const Stitch& stitch : pattern.stitches) {
    int &first = count[list.Index(stitch.first)], &second = count[list.Index(stitch.second)];
    first = second = (first + second + 1) / 2;
  }
  return count;
}

void CheckSize(const Pattern& pattern, double edge, const std::string& where) {
  if (!(edge >= kLeastEdge && edge <= kMostEdge))
    throw InputError(where,
                     Format("edges of %g m, expected %g … %g m", edge, kLeastEdge, kMostEdge));
  double area = 0;
  for (const Panel& panel : pattern.panels) area += LoopArea(panel.outline);
  const double vertices = area / (edge * edge * std::sqrt(3) / 2);
  if (vertices > kMostVertices)
    throw InputError(where, Format("%.3g vertices at edges of %g m, expected at most %.0f",
                                   vertices, edge, kMostVertices));
}

// Collects the panels in one list of vertices.
class Assembler {
 public:
  Assembler(const Pattern& pattern, double edge, const std::string& where)
      : pattern_(pattern), list_(pattern) {
    const std::vector<int> count = CountSegments(pattern, list_, edge);
    for (size_t p = 0; p < pattern.panels.size(); ++p) {
      const auto begin = count.begin() + list_.first(static_cast<int>(p));
      const Panel& panel = pattern.panels[p];
      Add(panel, MakePanelMesh(panel, {begin, begin + panel.num_edges()}, edge, where));
    }
  }

  GarmentMesh Result() {
    const int n = static_cast<int>(uv_.size());
    Eigen::Matrix2Xd uv(2, n);
    Eigen::VectorXd rest = Eigen::VectorXd::Zero(3 * n);
    result_.start_x.resize(3 * n);
    for (int i = 0; i < n; ++i) {
      uv.col(i) = rest.segment<2>(3 * i) = uv_[i];
      result_.start_x.segment<3>(3 * i) = start_[i];
    }
    result_.mesh = BuildMesh(rest, uv, triangles_, "garment");
    result_.panel_begin.push_back(n);
    AddStitches();
    AddRings();
    return std::move(result_);
  }

 private:
  void Add(const Panel& panel, const PanelMesh& made) {
    const int first = static_cast<int>(uv_.size());
    result_.panel_begin.push_back(first);
    const double shift = right_ - made.points.row(0).minCoeff();
    for (Eigen::Index i = 0; i < made.points.cols(); ++i) {
      uv_.emplace_back(made.points(0, i) + shift, made.points(1, i));
      start_.push_back(panel.Place(made.points.col(i)));
    }
    right_ += made.points.row(0).maxCoeff() - made.points.row(0).minCoeff() + kPanelGap;
    for (const auto& t : made.triangles)
      triangles_.push_back({t[0] + first, t[1] + first, t[2] + first});
    for (std::vector<int> edge : made.edges) {
      for (int& vertex : edge) vertex += first;
      edges_.push_back(std::move(edge));
    }
  }

  void AddStitches() {
    std::set<std::pair<int, int>> pairs;
    for (const Stitch& stitch : pattern_.stitches) {
      const std::vector<int>& first = edges_[list_.Index(stitch.first)];
      std::vector<int> second = edges_[list_.Index(stitch.second)];
      if (!stitch.same_direction) std::reverse(second.begin(), second.end());
      for (size_t i = 0; i < first.size(); ++i)
        if (first[i] != second[i]) pairs.insert(std::minmax(first[i], second[i]));
    }
    result_.stitches.assign(pairs.begin(), pairs.end());
  }

  void AddRings() {
    for (const Ring& ring : pattern_.rings) {
      std::set<int> vertices;
      for (const int e : ring.edges) {
        const auto& edge = edges_[list_.Index({ring.panel, e})];
        vertices.insert(edge.begin(), edge.end());
      }
      result_.rings.push_back({ring.name, {vertices.begin(), vertices.end()}, ring.held_by_pelvis});
    }
  }

  const Pattern& pattern_;
  EdgeList list_;
  double right_ = 0;  // where the next panel begins [m]
  std::vector<Eigen::Vector2d> uv_;
  std::vector<Eigen::Vector3d> start_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::vector<int>> edges_;
  GarmentMesh result_;
};

// The first vertex of each group of stitched ones, for all vertices.
std::vector<int> FirstOfGroups(const GarmentMesh& garment) {
  std::vector<int> first(garment.mesh.num_vertices());
  std::iota(first.begin(), first.end(), 0);
  const auto find = [&](int i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  for (const auto& [a, b] : garment.stitches) {
    const int one = find(a), other = find(b);
    first[std::max(one, other)] = std::min(one, other);
  }
  for (int i = 0; i < static_cast<int>(first.size()); ++i) first[i] = find(i);
  return first;
}

// Numbers without gaps in the order of the groups' first vertices.
std::vector<int> Number(const std::vector<int>& first) {
  std::vector<int> number(first.size());
  int count = 0;
  for (int i = 0; i < static_cast<int>(first.size()); ++i)
    number[i] = first[i] == i ? count++ : number[first[i]];
  return number;
}

Scene Falling() {
  Scene scene;
  scene.gravity = Eigen::Vector3d(0.0, 0.0, -9.8);
  return scene;
}

}  // namespace

GarmentMesh MakeGarmentMesh(const Pattern& pattern, double edge, const std::string& where) {
  CheckSize(pattern, edge, where);
  return Assembler(pattern, edge, where).Result();
}

void CheckSeams(const GarmentMesh& garment, const Pattern& pattern, const std::string& where) {
  const std::vector<int> first = FirstOfGroups(garment);
  std::set<std::set<int>> known;
  for (const Face& face : garment.mesh.faces) {
    std::set<int> corners;
    for (const int i : face.vertex) corners.insert(first[i]);
    if (corners.size() < 3 || known.insert(corners).second) continue;
    size_t panel = 0;
    while (garment.panel_begin[panel + 1] <= face.vertex[0]) ++panel;
    throw InputError(where, "found seams that lay a face of panel '" +
                                MakePrintableLine(pattern.panels[panel].name) +
                                "' on another one, expected a seam in the other direction, or "
                                "shorter edges");
  }
}

SewnGarment Sew(const GarmentMesh& garment, const Law& law) {
  SewnGarment sewn{.vertex_of = Number(FirstOfGroups(garment))};
  const int count = 1 + *std::max_element(sewn.vertex_of.begin(), sewn.vertex_of.end());
  Mesh mesh = garment.mesh;
  mesh.boundary_loops.clear();
  mesh.uv.resize(2, count);
  sewn.start_x = Eigen::VectorXd::Zero(3 * count);
  Eigen::VectorXd joined = Eigen::VectorXd::Zero(count);
  for (int i = 0; i < garment.mesh.num_vertices(); ++i) {
    const int k = sewn.vertex_of[i];
    mesh.uv.col(k) = garment.mesh.uv.col(i);
    sewn.start_x.segment<3>(3 * k) += garment.start_x.segment<3>(3 * i);
    joined[k] += 1.0;
  }
  for (int k = 0; k < count; ++k) sewn.start_x.segment<3>(3 * k) /= joined[k];
  mesh.rest_x = sewn.start_x;
  for (Face& face : mesh.faces)
    for (int& i : face.vertex) i = sewn.vertex_of[i];
  for (Hinge& hinge : mesh.hinges)
    for (int& i : hinge.vertex) i = sewn.vertex_of[i];
  for (const GarmentMesh::HeldRing& ring : garment.rings)
    if (ring.held_by_pelvis)
      for (const int i : ring.vertices) sewn.held_by_pelvis.push_back(sewn.vertex_of[i]);
  std::sort(sewn.held_by_pelvis.begin(), sewn.held_by_pelvis.end());
  sewn.held_by_pelvis.erase(std::unique(sewn.held_by_pelvis.begin(), sewn.held_by_pelvis.end()),
                            sewn.held_by_pelvis.end());
  sewn.model = std::make_shared<const ClothModel>(std::move(mesh), Falling(), law);
  return sewn;
}

}  // namespace drape
