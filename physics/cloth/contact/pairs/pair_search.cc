// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/pair_search.h"

#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <limits>

namespace drape {
namespace {

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;

// The boxes around parts of a cloth, each `more` [m] larger on all sides.
template <std::size_t N>
std::vector<Box> Enclose(const std::vector<std::array<int, N>>& parts, const VertexBoxes& boxes,
                         double more) {
  std::vector<Box> all;
  all.reserve(parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    Eigen::Array3d low = boxes.low.col(parts[k][0]), high = boxes.high.col(parts[k][0]);
    for (std::size_t i = 1; i < N; ++i) {
      low = low.min(boxes.low.col(parts[k][i]).array());
      high = high.max(boxes.high.col(parts[k][i]).array());
    }
    low -= more;
    high += more;
    all.emplace_back(low.data(), high.data(), static_cast<int>(k));
  }
  return all;
}

// The cells of a grid that boxes meet: most of a body is not near its garment, and to leave that
// out costs less than the search among it.
class OccupiedCells {
 public:
  explicit OccupiedCells(const std::vector<Box>& boxes) {
    Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity()),
                   high = -low;
    for (const Box& box : boxes) {
      low = low.min(Low(box));
      high = high.max(High(box));
    }
    if (boxes.empty()) return;
    origin_ = low;
    cell_ = std::max(kCell, (high - low).maxCoeff() / kMostCells);
    cells_ = ((high - low) / cell_).floor().cast<int>() + 1;
    is_occupied_.assign(static_cast<std::size_t>(cells_.prod()), false);
    for (const Box& box : boxes) ForEachCell(box, [&](int cell) { is_occupied_[cell] = true; });
  }

  void RemoveBoxesElsewhere(std::vector<Box>& boxes) const {
    std::erase_if(boxes, [&](const Box& box) {
      bool meets = false;
      ForEachCell(box, [&](int cell) { meets = meets || is_occupied_[cell]; });
      return !meets;
    });
  }

 private:
  static constexpr double kCell = 0.03;      // [m]
  static constexpr double kMostCells = 100;  // along an axis

  static Eigen::Array3d Low(const Box& box) {
    return {box.min_coord(0), box.min_coord(1), box.min_coord(2)};
  }
  static Eigen::Array3d High(const Box& box) {
    return {box.max_coord(0), box.max_coord(1), box.max_coord(2)};
  }
  template <class Visit>
  void ForEachCell(const Box& box, const Visit& visit) const {
    const Eigen::Array3d from = ((Low(box) - origin_) / cell_).floor().max(0.0),
                         to =
                             ((High(box) - origin_) / cell_).floor().min(cells_.cast<double>() - 1);
    for (int i = static_cast<int>(from[0]); i <= to[0]; ++i)
      for (int j = static_cast<int>(from[1]); j <= to[1]; ++j)
        for (int k = static_cast<int>(from[2]); k <= to[2]; ++k)
          visit((i * cells_[1] + j) * cells_[2] + k);
  }

  Eigen::Array3d origin_ = Eigen::Array3d::Zero();
  double cell_ = kCell;
  Eigen::Array3i cells_ = Eigen::Array3i::Zero();
  std::vector<bool> is_occupied_;
};

// The boxes around the parts of a surface.
struct SurfaceBoxes {
  SurfaceBoxes(const SurfaceParts& parts, const VertexBoxes& boxes, double more)
      : vertices(Enclose(Singles(parts.vertices), boxes, more)),
        edges(Enclose(parts.edges, boxes, more)),
        triangles(Enclose(parts.triangles, boxes, more)) {}
  void KeepNear(const SurfaceBoxes& other) {
    const OccupiedCells cells(other.triangles);
    for (std::vector<Box>* each : {&vertices, &edges, &triangles})
      cells.RemoveBoxesElsewhere(*each);
  }

  std::vector<Box> vertices, edges, triangles;

 private:
  static std::vector<std::array<int, 1>> Singles(const std::vector<int>& vertices) {
    std::vector<std::array<int, 1>> singles;
    for (const int i : vertices) singles.push_back({i});
    return singles;
  }
};

// Calls add(vertex, triangle) for the numbers of all in these lists whose boxes meet.
template <class Add>
void ForEachVertexAndFace(std::vector<Box>& vertices, std::vector<Box>& triangles, const Add& add) {
  CGAL::box_intersection_d(vertices.begin(), vertices.end(), triangles.begin(), triangles.end(),
                           [&](const Box& a, const Box& b) { add(a.info(), b.info()); });
}

}  // namespace

std::vector<ContactPair> ListPairsWithin(const SurfaceParts& cloth, const VertexBoxes& boxes,
                                         double reach) {
  std::vector<ContactPair> pairs;
  SurfaceBoxes around(cloth, boxes, 0.5 * reach);
  ForEachVertexAndFace(around.vertices, around.triangles, [&](int vertex, int triangle) {
    const int i = cloth.vertices[vertex];
    const auto& [p, q, r] = cloth.triangles[triangle];
    if (i != p && i != q && i != r) pairs.push_back({false, {i, p, q, r}});
  });
  CGAL::box_self_intersection_d(around.edges.begin(), around.edges.end(),
                                [&](const Box& a, const Box& b) {
                                  const auto& [p, q] = cloth.edges[std::min(a.info(), b.info())];
                                  const auto& [r, s] = cloth.edges[std::max(a.info(), b.info())];
                                  if (p != r && p != s && q != r && q != s)
                                    pairs.push_back({true, {p, q, r, s}});
                                });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<ContactPair> ListPairsBetween(const SurfaceParts& cloth, const SurfaceParts& obstacle,
                                          const VertexBoxes& boxes, double reach) {
  std::vector<ContactPair> pairs;
  SurfaceBoxes of_cloth(cloth, boxes, 0.5 * reach), of_obstacle(obstacle, boxes, 0.5 * reach);
  of_obstacle.KeepNear(of_cloth);
  of_cloth.KeepNear(of_obstacle);
  const auto add_to = [&](const std::vector<int>& vertices,
                          const std::vector<std::array<int, 3>>& triangles) {
    return [&](int vertex, int triangle) {
      const auto& [p, q, r] = triangles[triangle];
      pairs.push_back({false, {vertices[vertex], p, q, r}});
    };
  };
  ForEachVertexAndFace(of_cloth.vertices, of_obstacle.triangles,
                       add_to(cloth.vertices, obstacle.triangles));
  ForEachVertexAndFace(of_obstacle.vertices, of_cloth.triangles,
                       add_to(obstacle.vertices, cloth.triangles));
  CGAL::box_intersection_d(of_cloth.edges.begin(), of_cloth.edges.end(), of_obstacle.edges.begin(),
                           of_obstacle.edges.end(), [&](const Box& a, const Box& b) {
                             const auto& [p, q] = cloth.edges[a.info()];
                             const auto& [r, s] = obstacle.edges[b.info()];
                             pairs.push_back({true, {p, q, r, s}});
                           });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace drape
