// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/obstacles/surface_obstacle.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "physics/cloth/contact/obstacles/obstacle.h"
#include "physics/cloth/contact/pairs/contact_pair.h"

namespace drape {
namespace {

constexpr double kCell = 0.02;   // [m], about a triangle of a body
constexpr int kMostCells = 128;  // along an axis
// More cells than these in the box of a triangle are looked at one by one.
constexpr int kManyCells = 1000;
constexpr double kSharp = M_PI / 6;  // between the normals of two facets

}  // namespace

SurfaceObstacle::SurfaceObstacle(Eigen::Matrix3Xd x, std::vector<std::array<int, 3>> triangles,
                                 Eigen::Matrix3Xd before, double reach, SurfaceBlend blend)
    : x_(std::move(x)),
      before_(std::move(before)),
      triangles_(std::move(triangles)),
      reach_(reach) {
  CHECK(before_.cols() == 0 || before_.cols() == x_.cols());
  CHECK_GT(reach, 0.0);
  FindNormals();
  FindBalls();
  FillGrid();
  lists_.counted.assign(triangles_.size(), 0);
  if (blend == SurfaceBlend::kFacets) return;
  CountParts();
  is_convex_ = IsConvex();
}

SurfaceView SurfaceObstacle::view() const {
  SurfaceView view{.reach = reach_,
                   .cell = cell_,
                   .origin = Plain(origin_),
                   .is_convex = is_convex_,
                   .x = x_.data(),
                   .corner = triangles_.data()->data(),
                   .neighbour = lists_.neighbour.data()->data(),
                   .counted = lists_.counted.data(),
                   .centre = centre_.data(),
                   .radius = radius_.data(),
                   .face_normal = face_normal_.data(),
                   .corner_normal = corner_normal_.data(),
                   .cell_start = lists_.cell_start.data(),
                   .cell_triangle = lists_.cell_triangle.data()};
  for (int k = 0; k < 3; ++k) view.cells[k] = cells_[k];
  return view;
}

void SurfaceObstacle::FindNormals() {
  const auto count = static_cast<Eigen::Index>(triangles_.size());
  face_normal_.resize(3, count);
  corner_normal_ = Eigen::Matrix3Xd::Zero(3, x_.cols());
  lists_.neighbour.assign(triangles_.size(), {-1, -1, -1});
  std::map<std::pair<int, int>, std::pair<int, int>> of_edge;  // (from, to): triangle, corner
  for (int t = 0; t < count; ++t) {
    const auto& [a, b, c] = triangles_[t];
    face_normal_.col(t) = (x_.col(b) - x_.col(a)).cross(x_.col(c) - x_.col(a)).normalized();
    for (int k = 0; k < 3; ++k) {
      const int here = triangles_[t][k], next = triangles_[t][(k + 1) % 3],
                last = triangles_[t][(k + 2) % 3];
      const Eigen::Vector3d u = (x_.col(next) - x_.col(here)).normalized(),
                            v = (x_.col(last) - x_.col(here)).normalized();
      const double angle = std::acos(std::clamp(u.dot(v), -1.0, 1.0));
      corner_normal_.col(here) += angle * face_normal_.col(t);
      CHECK(of_edge.try_emplace({next, last}, t, k).second) << "an edge of two like triangles";
    }
  }
  for (const auto& [edge, side] : of_edge) {
    const auto other = of_edge.find({edge.second, edge.first});
    CHECK(other != of_edge.end()) << "a surface with a border";
    lists_.neighbour[side.first][side.second] = other->second.first;
  }
}

void SurfaceObstacle::FindBalls() {
  const auto count = static_cast<Eigen::Index>(triangles_.size());
  centre_.resize(3, count);
  radius_.resize(count);
  for (Eigen::Index t = 0; t < count; ++t) {
    const Eigen::Matrix3d corners = x_(Eigen::all, triangles_[t]);
    centre_.col(t) = corners.rowwise().mean();
    radius_[t] = (corners.colwise() - centre_.col(t)).colwise().norm().maxCoeff();
  }
}

// Whether the surface is bent inwards by more than kSharp over the edge opposite corner k of t.
bool SurfaceObstacle::IsSharplyConcave(int t, int k) const {
  const int other = lists_.neighbour[t][k];
  const Eigen::Vector3d normal = face_normal_.col(t);
  const Eigen::Vector3d across =
      x_(Eigen::all, triangles_[other]).rowwise().mean() - x_.col(triangles_[t][(k + 1) % 3]);
  return normal.dot(face_normal_.col(other)) < std::cos(kSharp) && normal.dot(across) > 0.0;
}

// The first triangle of an edge or corner keeps it.
void SurfaceObstacle::CountParts() {
  std::vector<char> is_left_out(x_.cols(), 0);
  for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
    for (int k = 0; k < 3; ++k) {
      if (!IsSharplyConcave(t, k)) {
        if (t < lists_.neighbour[t][k]) lists_.counted[t] |= CountedEdge(k);
        continue;
      }
      is_left_out[triangles_[t][(k + 1) % 3]] = is_left_out[triangles_[t][(k + 2) % 3]] = 1;
    }
  for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
    for (int k = 0; k < 3; ++k) {
      char& corner = is_left_out[triangles_[t][k]];
      if (corner == 0) lists_.counted[t] |= CountedCorner(k);
      corner = 1;
    }
}

bool SurfaceObstacle::IsConvex() const {
  const double rounding = 1e-12 * x_.cwiseAbs().maxCoeff();
  for (Eigen::Index t = 0; t < face_normal_.cols(); ++t) {
    const Eigen::Vector3d normal = face_normal_.col(t);
    const double plane = normal.dot(x_.col(triangles_[t][0]));
    if ((normal.transpose() * x_).maxCoeff() > plane + rounding) return false;
  }
  return true;
}

// Whether some point of the cell can be within reach of triangle t.
bool SurfaceObstacle::IsInReach(int t, const Eigen::Vector3i& cell) const {
  const Eigen::Vector3d middle = origin_ + cell_ * (cell.cast<double>().array() + 0.5).matrix();
  const Eigen::Matrix3d corners = x_(Eigen::all, triangles_[t]);
  const Eigen::Vector3d nearest =
      corners * NearestWeights(middle, Eigen::Vector3d(corners.col(0)),
                               Eigen::Vector3d(corners.col(1)), Eigen::Vector3d(corners.col(2)));
  return (middle - nearest).norm() < reach_ + 0.5 * std::sqrt(3.0) * cell_;
}

void SurfaceObstacle::FillGrid() {
  origin_ = x_.rowwise().minCoeff().array() - reach_;
  const Eigen::Vector3d extent = x_.rowwise().maxCoeff().array() + reach_ - origin_.array();
  cell_ = std::max(kCell, extent.maxCoeff() / kMostCells);
  cells_ = (extent / cell_).array().floor().cast<int>() + 1;
  // Each triangle in all cells that its box, inflated by the reach, meets: counted, then filled.
  lists_.cell_start.assign(static_cast<std::size_t>(cells_.prod()) + 1, 0);
  const auto for_each = [&](const auto& visit) {
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
      const Eigen::Matrix3d corners = x_(Eigen::all, triangles_[t]);
      const Eigen::Vector3i low = Cell(corners.rowwise().minCoeff().array() - reach_).cwiseMax(0);
      const Eigen::Vector3i high = Cell(corners.rowwise().maxCoeff().array() + reach_)
                                       .cwiseMin(cells_ - Eigen::Vector3i::Ones());
      const bool is_large = (high - low + Eigen::Vector3i::Ones()).prod() > kManyCells;
      for (int i = low[0]; i <= high[0]; ++i)
        for (int j = low[1]; j <= high[1]; ++j)
          for (int k = low[2]; k <= high[2]; ++k)
            if (!is_large || IsInReach(t, {i, j, k})) visit((i * cells_[1] + j) * cells_[2] + k, t);
    }
  };
  for_each([&](int cell, int) { ++lists_.cell_start[cell + 1]; });
  for (std::size_t c = 1; c < lists_.cell_start.size(); ++c)
    lists_.cell_start[c] += lists_.cell_start[c - 1];
  lists_.cell_triangle.resize(lists_.cell_start.back());
  std::vector<int> next(lists_.cell_start.begin(), lists_.cell_start.end() - 1);
  for_each([&](int cell, int t) { lists_.cell_triangle[next[cell]++] = t; });
}

Eigen::Vector3i SurfaceObstacle::Cell(const Eigen::Vector3d& x) const {
  return ((x - origin_) / cell_).array().floor().cast<int>();
}

Eigen::Vector3d SurfaceObstacle::Move(const Eigen::Vector3d& x) const {
  const SurfacePoint nearest = FindNearest(view(), Plain(x));
  if (nearest.triangle < 0 || before_.cols() == 0) return Eigen::Vector3d::Zero();
  const std::array<int, 3>& corners = triangles_[nearest.triangle];
  return (x_(Eigen::all, corners) - before_(Eigen::all, corners)) *
         Eigen::Vector3d(nearest.weights.x, nearest.weights.y, nearest.weights.z);
}

bool SurfaceObstacle::Encloses(const Eigen::Vector3d& x) const {
  if (((x - x_.rowwise().minCoeff()).array() < 0.0).any() ||
      ((x - x_.rowwise().maxCoeff()).array() > 0.0).any())
    return false;
  double angle = 0.0;  // at which the surface is seen from x, 4π from inside
  for (const std::array<int, 3>& corners : triangles_) {
    const Eigen::Matrix3d r = x_(Eigen::all, corners).colwise() - x;
    const Eigen::Vector3d length = r.colwise().norm();
    const double volume = r.determinant();
    angle += 2.0 * std::atan2(volume, length.prod() + r.col(0).dot(r.col(1)) * length[2] +
                                          r.col(1).dot(r.col(2)) * length[0] +
                                          r.col(2).dot(r.col(0)) * length[1]);
  }
  return angle > 2.0 * M_PI;
}

ObstacleDistance SurfaceObstacle::DistanceTo(const Eigen::Vector3d& x) const {
  return InEigen(drape::DistanceTo(view(), Plain(x)));
}

}  // namespace drape
