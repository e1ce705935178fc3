// SPDX-License-Identifier: Apache-2.0
#include "losses/raster.h"

#include <glog/logging.h>

#include "losses/silhouette_border.h"

namespace drape {
namespace {

void CoverTriangle(const Eigen::Matrix2Xd& points, const Face& face, int width, int height,
                   uint8_t* covered) {
  const auto a = points.col(face.vertex[0]), b = points.col(face.vertex[1]),
             c = points.col(face.vertex[2]);
  const Eigen::Vector2d min = a.cwiseMin(b).cwiseMin(c), max = a.cwiseMax(b).cwiseMax(c);
  const PixelRange columns = PixelsIn(min.x(), max.x(), width);
  const PixelRange rows = PixelsIn(min.y(), max.y(), height);
  for (int row = rows.first; row <= rows.last; ++row) {
    for (int col = columns.first; col <= columns.last; ++col) {
      uint8_t& pixel = covered[size_t(row) * width + col];
      if (!pixel && Covers(points.data(), face, {double(col), double(row)})) pixel = 1;
    }
  }
}

}  // namespace

std::vector<uint8_t> CoveredPixels(const Mesh& mesh, const Eigen::Matrix2Xd& image_points,
                                   int width, int height) {
  std::vector<uint8_t> covered(size_t(width) * height, 0);
  for (const Face& face : mesh.faces) {
    CoverTriangle(image_points, face, width, height, covered.data());
  }
  return covered;
}

GrayImage Rasterize(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera,
                    int supersample) {
  CHECK_GE(supersample, 1);
  const int n = supersample, fine_width = n * camera.width;
  Eigen::Matrix2Xd points;
  CHECK(ProjectVertices(x, camera, &points)) << "positions not finite or behind the camera";
  points = ((points.array() + 0.5) * n - 0.5).matrix();
  const auto covered = CoveredPixels(mesh, points, fine_width, n * camera.height);
  GrayImage image(camera.width, camera.height);
  for (size_t i = 0; i < covered.size(); ++i) {
    image.at(i % fine_width / n, i / fine_width / n) += covered[i];
  }
  for (float& c : image.coverage) c /= static_cast<float>(n * n);
  return image;
}

}  // namespace drape
