// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/garment_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/prediction/garment/panel_mesh.h"

namespace drape {
namespace {

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

}  // namespace

double GarmentMesh::WidestSeam() const {
  double widest = 0;
  for (const auto& [a, b] : stitches)
    widest = std::max(widest, (start_x.segment<3>(3 * a) - start_x.segment<3>(3 * b)).norm());
  return widest;
}

GarmentMesh MakeGarmentMesh(const Pattern& pattern, double edge, const std::string& where) {
  CheckSize(pattern, edge, where);
  return Assembler(pattern, edge, where).Result();
}

}  // namespace drape
