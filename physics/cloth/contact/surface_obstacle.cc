// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/surface_obstacle.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "physics/cloth/contact/obstacle.h"
#include "physics/cloth/contact/pairs/nearest_points.h"

namespace drape {
namespace {

constexpr double kCell = 0.02;  // [m], about a triangle of a body
// Distances from triangles are blended over this length [m], and without weight so many of them
// off.
constexpr double kBlend = 3e-4, kFaded = 20.0;

}  // namespace

SurfaceObstacle::SurfaceObstacle(Eigen::Matrix3Xd x, std::vector<std::array<int, 3>> triangles,
                                 Eigen::Matrix3Xd before, double reach)
    : x_(std::move(x)),
      before_(std::move(before)),
      triangles_(std::move(triangles)),
      reach_(reach) {
  CHECK(before_.cols() == 0 || before_.cols() == x_.cols());
  CHECK_GT(reach, 0.0);
  FindNormals();
  FindBalls();
  FillGrid();
}

void SurfaceObstacle::FindNormals() {
  const auto count = static_cast<Eigen::Index>(triangles_.size());
  face_normal_.resize(3, count);
  corner_normal_ = Eigen::Matrix3Xd::Zero(3, x_.cols());
  neighbour_.assign(triangles_.size(), {-1, -1, -1});
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
    neighbour_[side.first][side.second] = other->second.first;
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

void SurfaceObstacle::FillGrid() {
  origin_ = x_.rowwise().minCoeff().array() - reach_;
  const Eigen::Vector3d extent = x_.rowwise().maxCoeff().array() + reach_ - origin_.array();
  cells_ = (extent / kCell).array().floor().cast<int>() + 1;
  // Each triangle in all cells that its box, inflated by the reach, meets: counted, then filled.
  cell_start_.assign(static_cast<std::size_t>(cells_.prod()) + 1, 0);
  const auto for_each = [&](const auto& visit) {
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
      const Eigen::Matrix3d corners = x_(Eigen::all, triangles_[t]);
      const Eigen::Vector3i low = Cell(corners.rowwise().minCoeff().array() - reach_);
      const Eigen::Vector3i high = Cell(corners.rowwise().maxCoeff().array() + reach_);
      for (int i = std::max(0, low[0]); i <= std::min(high[0], cells_[0] - 1); ++i)
        for (int j = std::max(0, low[1]); j <= std::min(high[1], cells_[1] - 1); ++j)
          for (int k = std::max(0, low[2]); k <= std::min(high[2], cells_[2] - 1); ++k)
            visit((i * cells_[1] + j) * cells_[2] + k, t);
    }
  };
  for_each([&](int cell, int) { ++cell_start_[cell + 1]; });
  for (std::size_t c = 1; c < cell_start_.size(); ++c) cell_start_[c] += cell_start_[c - 1];
  cell_triangle_.resize(cell_start_.back());
  std::vector<int> next(cell_start_.begin(), cell_start_.end() - 1);
  for_each([&](int cell, int t) { cell_triangle_[next[cell]++] = t; });
}

Eigen::Vector3i SurfaceObstacle::Cell(const Eigen::Vector3d& x) const {
  return ((x - origin_) / kCell).array().floor().cast<int>();
}

std::span<const int> SurfaceObstacle::TrianglesNear(const Eigen::Vector3d& x) const {
  const Eigen::Array3d place = (x - origin_) / kCell;
  if (!(place.minCoeff() >= 0.0 && (place < cells_.cast<double>().array()).all())) return {};
  const Eigen::Vector3i cell = Cell(x);
  const int c = (cell[0] * cells_[1] + cell[1]) * cells_[2] + cell[2];
  return {cell_triangle_.data() + cell_start_[c], cell_triangle_.data() + cell_start_[c + 1]};
}

Eigen::Vector3d SurfaceObstacle::Place(const Nearest& nearest) const {
  return x_(Eigen::all, triangles_[nearest.triangle]) * nearest.weights;
}

SurfaceObstacle::Nearest SurfaceObstacle::FindNearest(const Eigen::Vector3d& x) const {
  Nearest nearest;
  double least = reach_;
  for (const int t : TrianglesNear(x)) {
    if ((x - centre_.col(t)).squaredNorm() > std::pow(least + radius_[t], 2)) continue;
    const auto& [p, q, r] = triangles_[t];
    const Nearest other{t, NearestWeights(x, x_.col(p), x_.col(q), x_.col(r))};
    const double length = (x - Place(other)).norm();
    if (length >= least) continue;
    least = length;
    nearest = other;
  }
  return nearest;
}

Eigen::Vector3d SurfaceObstacle::PseudoNormal(const Nearest& nearest) const {
  const std::array<int, 3>& corners = triangles_[nearest.triangle];
  const Eigen::Vector3d& weights = nearest.weights;
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 1.0) return corner_normal_.col(corners[k]);
  for (int k = 0; k < 3; ++k)
    if (weights[k] == 0.0)
      return face_normal_.col(nearest.triangle) + face_normal_.col(neighbour_[nearest.triangle][k]);
  return face_normal_.col(nearest.triangle);
}

Eigen::Vector3d SurfaceObstacle::Move(const Eigen::Vector3d& x) const {
  const Nearest nearest = FindNearest(x);
  if (nearest.triangle < 0 || before_.cols() == 0) return Eigen::Vector3d::Zero();
  const std::array<int, 3>& corners = triangles_[nearest.triangle];
  return (x_(Eigen::all, corners) - before_(Eigen::all, corners)) * nearest.weights;
}

ObstacleDistance SurfaceObstacle::DistanceTo(const Eigen::Vector3d& x) const {
  const Nearest nearest = FindNearest(x);
  if (nearest.triangle < 0) return {.value = reach_};
  const Eigen::Vector3d offset = x - Place(nearest);
  const double least = offset.norm();
  if (!(least > 0.0)) return {.value = 0.0, .normal = face_normal_.col(nearest.triangle)};
  if (offset.dot(PseudoNormal(nearest)) < 0.0) return {.value = -least, .normal = -offset / least};
  double sum = 0.0;
  ObstacleDistance distance;
  const double most = least + kFaded * kBlend;
  for (const int t : TrianglesNear(x)) {
    if ((x - centre_.col(t)).squaredNorm() > std::pow(most + radius_[t], 2)) continue;
    const auto& [p, q, r] = triangles_[t];
    const Eigen::Vector3d away = x - Place({t, NearestWeights(x, x_.col(p), x_.col(q), x_.col(r))});
    const double length = away.norm();
    if (length > most) continue;
    const double weight = std::exp(-(length - least) / kBlend);
    sum += weight;
    const Eigen::Vector3d normal = away / length;
    distance.normal += weight * normal;
    distance.curvature += weight * normal * normal.transpose();
  }
  distance.normal /= sum;
  distance.curvature =
      (distance.normal * distance.normal.transpose() - distance.curvature / sum) / kBlend;
  distance.value = least - kBlend * std::log(sum);
  return distance;
}

}  // namespace drape
