// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/cloud_readouts.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/Simple_cartesian.h>
#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/cloth/contact/pairs/contact_pair.h"

namespace drape {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using TriangleTree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>>>;
using Neighbours = CGAL::Orthogonal_k_neighbor_search<CGAL::Search_traits_3<Kernel>>;

Point PointAt(const Eigen::VectorXd& x, Eigen::Index i) {
  return {x[3 * i], x[3 * i + 1], x[3 * i + 2]};
}

// p − q of the closest place q of a triangle, and its derivatives by the corners.
struct Offset {
  Vector3d value;
  Matrix3d by_corner[3];
};

// Inside a face p − q = s·n with n the normal: its change is −n·Σ w_i(n·δ_i) − s Σ g_i (n·δ_i) for
// moves δ_i of the corners, with w_i the weights of q and g_i their gradients in the plane. On an
// edge of the direction t, P = I − ttᵀ: −P·(w_i δ_i + w_j δ_j) − t (p − q)ᵀ(δ_j − δ_i)/length.
Offset OffsetFrom(const Matrix3d& corners, const Vector3d& p) {
  const Vector3d weights = NearestWeights(p, corners.col(0), corners.col(1), corners.col(2));
  Offset offset{p - corners * weights, {}};
  for (Matrix3d& by : offset.by_corner) by.setZero();
  const auto zeros = (weights.array() == 0.0).count();
  if (zeros == 0) {
    const Vector3d twice = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
    const Vector3d n = twice.normalized();
    const double s = n.dot(p - corners.col(0));
    offset.value = s * n;
    for (int i = 0; i < 3; ++i) {
      const Vector3d opposite = corners.col((i + 2) % 3) - corners.col((i + 1) % 3);
      const Vector3d gradient = n.cross(opposite) / twice.norm();
      offset.by_corner[i] = -(weights[i] * n + s * gradient) * n.transpose();
    }
  } else if (zeros == 1) {
    const int k = weights[0] == 0.0 ? 0 : weights[1] == 0.0 ? 1 : 2;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const Vector3d edge = corners.col(j) - corners.col(i), t = edge.normalized();
    const Matrix3d across = Matrix3d::Identity() - t * t.transpose();
    const Matrix3d turn = t * offset.value.transpose() / edge.norm();
    offset.by_corner[i] = -weights[i] * across + turn;
    offset.by_corner[j] = -weights[j] * across - turn;
  } else {
    for (int i = 0; i < 3; ++i) offset.by_corner[i] = -weights[i] * Matrix3d::Identity();
  }
  return offset;
}

}  // namespace

PointCloudReadout::PointCloudReadout(const Mesh& mesh, Eigen::VectorXd points)
    : mesh_(mesh), points_(std::move(points)) {
  CHECK_EQ(points_.size() % 3, 0);
  CHECK(points_.allFinite());
}

bool PointCloudReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                             ReadoutJacobian* dr_dx) const {
  if (!x.allFinite()) return false;
  Triangles triangles;
  for (const Face& face : mesh_.faces) {
    const int* v = face.vertex;
    triangles.emplace_back(PointAt(x, v[0]), PointAt(x, v[1]), PointAt(x, v[2]));
    if (triangles.back().is_degenerate()) return false;
  }
  const TriangleTree tree(triangles.cbegin(), triangles.cend());
  r->resize(size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < size(); k += 3) {
    const auto nearest = tree.closest_point_and_primitive(PointAt(points_, k / 3)).second;
    const Face& face = mesh_.faces[nearest - triangles.cbegin()];
    Matrix3d corners;
    for (int i = 0; i < 3; ++i) corners.col(i) = x.segment<3>(3 * face.vertex[i]);
    const Offset offset = OffsetFrom(corners, points_.segment<3>(k));
    r->segment<3>(k) = offset.value;
    if (dr_dx == nullptr) continue;
    for (int entry = 0; entry < 27; ++entry) {
      const int i = entry / 9, row = entry / 3 % 3, column = entry % 3;
      entries.emplace_back(k + row, 3 * face.vertex[i] + column, offset.by_corner[i](row, column));
    }
  }
  if (dr_dx == nullptr) return true;
  dr_dx->resize(size(), x.size());
  dr_dx->setFromTriplets(entries.begin(), entries.end());
  return true;
}

struct UncoveredReadout::Tree {
  Neighbours::Tree points;
};

UncoveredReadout::UncoveredReadout(const Eigen::VectorXd& points, std::vector<int> vertices,
                                   const UncoveredOptions& options)
    : tree_(std::make_unique<Tree>()), vertices_(std::move(vertices)), options_(options) {
  CHECK(points.size() > 0 && points.size() % 3 == 0) << points.size();
  CHECK(points.allFinite());
  CHECK(options.spacing >= 0.0 && options.max_distance > options.spacing);
  for (Eigen::Index i = 0; i < points.size() / 3; ++i) tree_->points.insert(PointAt(points, i));
  tree_->points.build();  // else the first search would, which may be several at a time
}

UncoveredReadout::~UncoveredReadout() = default;

bool UncoveredReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                            ReadoutJacobian* dr_dx) const {
  if (!x.allFinite()) return false;
  r->resize(size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < size(); ++k) {
    const int vertex = vertices_[k];
    CHECK(vertex >= 0 && 3 * vertex < x.size()) << vertex;
    const Point nearest = Neighbours(tree_->points, PointAt(x, vertex), 1).begin()->first;
    const Vector3d away =
        x.segment<3>(3 * vertex) - Vector3d(nearest.x(), nearest.y(), nearest.z());
    const double distance = away.norm();
    (*r)[k] = std::max(0.0, std::min(distance, options_.max_distance) - options_.spacing);
    if ((*r)[k] == 0.0 || distance >= options_.max_distance) continue;
    for (int d = 0; d < 3; ++d) entries.emplace_back(k, 3 * vertex + d, away[d] / distance);
  }
  if (dr_dx == nullptr) return true;
  dr_dx->resize(size(), x.size());
  dr_dx->setFromTriplets(entries.begin(), entries.end());
  return true;
}

}  // namespace drape
