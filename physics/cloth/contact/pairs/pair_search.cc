// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/pairs/pair_search.h"

#include <CGAL/box_intersection_d.h>

#include <algorithm>

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

}  // namespace

std::vector<ContactPair> ListPairsWithin(const std::vector<std::array<int, 2>>& edges,
                                         const std::vector<std::array<int, 3>>& triangles,
                                         const VertexBoxes& boxes, double reach) {
  std::vector<ContactPair> pairs;
  std::vector<std::array<int, 1>> vertices(boxes.low.cols());
  for (std::size_t i = 0; i < vertices.size(); ++i) vertices[i] = {static_cast<int>(i)};
  std::vector<Box> of_vertices = Enclose(vertices, boxes, 0.5 * reach),
                   of_triangles = Enclose(triangles, boxes, 0.5 * reach),
                   of_edges = Enclose(edges, boxes, 0.5 * reach);
  CGAL::box_intersection_d(of_vertices.begin(), of_vertices.end(), of_triangles.begin(),
                           of_triangles.end(), [&](const Box& a, const Box& b) {
                             const int i = a.info();
                             const auto& [p, q, r] = triangles[b.info()];
                             if (i != p && i != q && i != r) pairs.push_back({false, {i, p, q, r}});
                           });
  CGAL::box_self_intersection_d(of_edges.begin(), of_edges.end(), [&](const Box& a, const Box& b) {
    const auto& [p, q] = edges[std::min(a.info(), b.info())];
    const auto& [r, s] = edges[std::max(a.info(), b.info())];
    if (p != r && p != s && q != r && q != s) pairs.push_back({true, {p, q, r, s}});
  });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace drape
