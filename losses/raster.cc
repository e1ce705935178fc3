// SPDX-License-Identifier: Apache-2.0
#include "losses/raster.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

namespace drape {
namespace {

// Pixels lo … hi of [0, size) whose centres lie in [min, max]; empty when lo > hi.
struct PixelRange {
  PixelRange(double min, double max, int size)
      : lo(static_cast<int>(std::ceil(std::clamp(min, 0.0, double(size))))),
        hi(static_cast<int>(std::floor(std::clamp(max, -1.0, size - 1.0)))) {}
  int lo, hi;
};

void CoverTriangle(const Eigen::Matrix2Xd& points, const int* triangle, int width, int height,
                   uint8_t* covered) {
  const auto a = points.col(triangle[0]), b = points.col(triangle[1]), c = points.col(triangle[2]);
  const Eigen::Vector2d min = a.cwiseMin(b).cwiseMin(c), max = a.cwiseMax(b).cwiseMax(c);
  const PixelRange columns(min.x(), max.x(), width), rows(min.y(), max.y(), height);
  for (int row = rows.lo; row <= rows.hi; ++row) {
    for (int col = columns.lo; col <= columns.hi; ++col) {
      uint8_t& pixel = covered[size_t(row) * width + col];
      if (!pixel && Covers(points, triangle, col, row)) pixel = 1;
    }
  }
}

}  // namespace

std::vector<uint8_t> CoveredPixels(const Mesh& mesh, const Eigen::Matrix2Xd& image_points,
                                   int width, int height) {
  std::vector<uint8_t> covered(size_t(width) * height, 0);
  for (const Face& face : mesh.faces) {
    CoverTriangle(image_points, face.vertex, width, height, covered.data());
  }
  return covered;
}

namespace {

// covered_pixels(points, width, height): which samples of the finer image are covered.
GrayImage RasterizeSamples(const Eigen::VectorXd& x, const Camera& camera, int supersample,
                           const auto& covered_pixels) {
  CHECK_GE(supersample, 1);
  const int n = supersample, fine_width = n * camera.width;
  Eigen::Matrix2Xd points;
  CHECK(ProjectVertices(x, camera, &points)) << "positions not finite or behind the camera";
  points = ((points.array() + 0.5) * n - 0.5).matrix();
  const std::vector<uint8_t> covered = covered_pixels(points, fine_width, n * camera.height);
  GrayImage image(camera.width, camera.height);
  for (size_t i = 0; i < covered.size(); ++i) {
    image.at(i % fine_width / n, i / fine_width / n) += covered[i];
  }
  for (float& c : image.coverage) c /= static_cast<float>(n * n);
  return image;
}

}  // namespace

GrayImage Rasterize(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    int supersample) {
  return RasterizeSamples(x, camera, supersample,
                          [&](const Eigen::Matrix2Xd& points, int width, int height) {
                            return CoveredPixels(mesh, points, width, height);
                          });
}

GrayImage Rasterize(const ObjSurface& surface, const Camera& camera, int supersample) {
  const auto cover = [&](const Eigen::Matrix2Xd& points, int width, int height) {
    std::vector<uint8_t> covered(size_t(width) * height, 0);
    for (const auto& triangle : surface.triangles)
      CoverTriangle(points, triangle.data(), width, height, covered.data());
    return covered;
  };
  return RasterizeSamples(surface.x, camera, supersample, cover);
}

}  // namespace drape
