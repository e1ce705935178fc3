// SPDX-License-Identifier: Apache-2.0
#include "losses/silhouette/raster.h"

#include <glog/logging.h>

#include "losses/silhouette/silhouette_border.h"

namespace drape {
namespace {

void CoverTriangle(const Eigen::Matrix2Xd& points, const int* triangle, int width, int height,
                   uint8_t* covered) {
  const auto a = points.col(triangle[0]), b = points.col(triangle[1]), c = points.col(triangle[2]);
  const Eigen::Vector2d min = a.cwiseMin(b).cwiseMin(c), max = a.cwiseMax(b).cwiseMax(c);
  const PixelRange columns = PixelsIn(min.x(), max.x(), width);
  const PixelRange rows = PixelsIn(min.y(), max.y(), height);
  for (int row = rows.first; row <= rows.last; ++row) {
    for (int col = columns.first; col <= columns.last; ++col) {
      uint8_t& pixel = covered[size_t(row) * width + col];
      if (!pixel && Covers(points.data(), triangle, {double(col), double(row)})) pixel = 1;
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

// covered_pixels(points, width, height) returns which samples of the finer image are covered.
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
