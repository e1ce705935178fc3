// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "losses/camera.h"
#include "losses/image.h"
#include "physics/mesh.h"
#include "physics/obj_io.h"

namespace drape {

// On which side of the edge i→j of the projected mesh the point lies: twice the signed area of the
// triangle (i, j, point) [px²]. Exactly antisymmetric in (i, j), so two triangles that share an
// edge leave no gap between them.
inline double EdgeSide(const Eigen::Matrix2Xd& points, int i, int j, double column, double row) {
  const double sign = i < j ? 1 : -1;
  if (i > j) std::swap(i, j);
  return sign * ((points(0, j) - points(0, i)) * (row - points(1, i)) -
                 (points(1, j) - points(1, i)) * (column - points(0, i)));
}

// Whether the closed projected triangle of three vertices holds the point, seen from either face. A
// triangle without area holds nothing.
inline bool Covers(const Eigen::Matrix2Xd& points, const int* triangle, double column, double row) {
  const int a = triangle[0], b = triangle[1], c = triangle[2];
  const double ab = EdgeSide(points, a, b, column, row);
  const double bc = EdgeSide(points, b, c, column, row);
  const double ca = EdgeSide(points, c, a, column, row);
  const bool inside = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  return inside && EdgeSide(points, a, b, points(0, c), points(1, c)) != 0;
}
inline bool Covers(const Eigen::Matrix2Xd& points, const Face& face, double column, double row) {
  return Covers(points, face.vertex, column, row);
}

// 1 for each pixel whose centre some triangle covers, row-major, shape [height, width].
// image_points: finite, [px], shape [2, V].
std::vector<uint8_t> CoveredPixels(const Mesh& mesh, const Eigen::Matrix2Xd& image_points,
                                   int width, int height);

// Hard silhouette of all triangles at positions x [m], shape [3V]: the share of supersample²
// samples of each pixel that are covered. x must be finite and in front of the camera (CHECK).
GrayImage Rasterize(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    int supersample = 1);
GrayImage Rasterize(const ObjSurface& surface, const Camera& camera, int supersample = 1);

}  // namespace drape
