// SPDX-License-Identifier: Apache-2.0
#include "physics/mesh/strip.h"

#include <glog/logging.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace drape {
namespace {

// Adds the triangles between an even row (n + 1 vertices from `even` on) and an odd row (n + 2
// vertices from `odd` on).
void AddRow(std::vector<std::array<int, 3>>& triangles, int even, int odd, int n,
            bool odd_is_above) {
  for (int i = 0; i <= n; ++i) {
    if (odd_is_above) {
      triangles.push_back({even + i, odd + i + 1, odd + i});
      if (i < n) triangles.push_back({even + i, even + i + 1, odd + i + 1});
    } else {
      triangles.push_back({odd + i, odd + i + 1, even + i});
      if (i < n) triangles.push_back({odd + i + 1, even + i + 1, even + i});
    }
  }
}

}  // namespace

Mesh MakeStrip(double length, double width, int n_along, int n_across) {
  CHECK(length > 0 && width > 0 && n_along > 0 && n_across > 0);
  std::vector<Eigen::Vector2d> points;
  std::vector<std::array<int, 3>> triangles;
  int previous = 0;
  for (int row = 0; row <= n_across; ++row) {
    const int first = static_cast<int>(points.size());
    const bool odd = row % 2 == 1;
    for (int i = 0; i <= n_along + odd; ++i) {
      const double place = odd ? std::clamp(i - 0.5, 0.0, 1.0 * n_along) : i;
      points.emplace_back(length * place / n_along, width * (1.0 * row / n_across - 0.5));
    }
    if (row > 0) AddRow(triangles, odd ? previous : first, odd ? first : previous, n_along, odd);
    previous = first;
  }
  Eigen::Matrix2Xd uv(2, points.size());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3 * uv.cols());
  for (int i = 0; i < uv.cols(); ++i) uv.col(i) = x.segment<2>(3 * i) = points[i];
  return BuildMesh(x, uv, triangles, "strip");
}

Mesh Laid(const Mesh& mesh, double place, double direction) {
  const Eigen::Matrix2d turn_place = Eigen::Rotation2Dd(place).toRotationMatrix();
  const Eigen::Matrix2d turn_cloth = Eigen::Rotation2Dd(direction).toRotationMatrix();
  Eigen::VectorXd x = mesh.rest_x;
  Eigen::Matrix2Xd place_xy =
      turn_place *
      Eigen::Map<const Eigen::Matrix3Xd>(x.data(), 3, mesh.num_vertices()).topRows<2>();
  place_xy.row(0).array() -= place_xy.row(0).minCoeff();
  place_xy.row(1).array() -= 0.5 * (place_xy.row(1).minCoeff() + place_xy.row(1).maxCoeff());
  for (int i = 0; i < mesh.num_vertices(); ++i) x.segment<2>(3 * i) = place_xy.col(i);
  const Eigen::Matrix2Xd uv = turn_cloth * place_xy;
  return BuildMesh(x, uv, ListTriangles(mesh), "laid mesh");
}

}  // namespace drape
