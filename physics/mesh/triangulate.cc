// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/triangulate.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/hilbert_sort.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <algorithm>

namespace drape {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Delaunay = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure>;
using IndexedPoint = std::pair<Kernel::Point_2, int>;

using SortTraits =
    CGAL::Spatial_sort_traits_adapter_2<Kernel, CGAL::First_of_pair_property_map<IndexedPoint>>;

std::vector<IndexedPoint> IndexedPoints(const Eigen::Matrix2Xd& points) {
  std::vector<IndexedPoint> indexed;
  for (int i = 0; i < points.cols(); ++i) {
    indexed.emplace_back(Kernel::Point_2(points(0, i), points(1, i)), i);
  }
  return indexed;
}

}  // namespace

std::vector<int> SpatialOrder(const Eigen::Matrix2Xd& points) {
  std::vector<IndexedPoint> sorted = IndexedPoints(points);
  CGAL::hilbert_sort(sorted.begin(), sorted.end(), SortTraits());
  std::vector<int> order;
  for (const auto& [point, index] : sorted) order.push_back(index);
  return order;
}

std::vector<std::array<int, 3>> Triangulate(const Eigen::Matrix2Xd& points,
                                            const std::vector<std::pair<int, int>>& edges) {
  Delaunay delaunay;
  std::vector<Delaunay::Vertex_handle> handles(points.cols());
  Delaunay::Face_handle near;
  std::vector<IndexedPoint> sorted = IndexedPoints(points);
  CGAL::spatial_sort(sorted.begin(), sorted.end(), SortTraits());
  for (const auto& [point, index] : sorted) {
    handles[index] = delaunay.insert(point, near);
    handles[index]->info() = index;
    near = handles[index]->face();
  }
  for (const auto& [a, b] : edges) delaunay.insert_constraint(handles[a], handles[b]);
  std::vector<std::array<int, 3>> triangles;
  for (const auto face : delaunay.finite_face_handles()) {
    std::array<int, 3> t = {face->vertex(0)->info(), face->vertex(1)->info(),
                            face->vertex(2)->info()};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

void MoveToCentroids(const std::vector<std::array<int, 3>>& triangles, int first_free,
                     Eigen::Matrix2Xd& points) {
  Eigen::Matrix2Xd sum = Eigen::Matrix2Xd::Zero(2, points.cols());
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(points.cols());
  for (const auto& t : triangles) {
    const Eigen::Vector2d a = points.col(t[0]), b = points.col(t[1]), c = points.col(t[2]);
    const Eigen::Vector2d e1 = b - a, e2 = c - a;
    const double area = e1.x() * e2.y() - e2.x() * e1.y();
    for (const int i : t) {
      sum.col(i) += area * (a + b + c) / 3;
      weight[i] += area;
    }
  }
  for (Eigen::Index i = first_free; i < points.cols(); ++i) points.col(i) = sum.col(i) / weight[i];
}

}  // namespace drape
