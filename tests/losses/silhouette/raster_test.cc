// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numeric>

#include "losses/silhouette/silhouette.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

double Area(const GrayImage& image) {
  return std::accumulate(image.coverage.begin(), image.coverage.end(), 0.0);
}

// The area [px²] of the projected hem by the shoelace formula.
double HemArea(const Mesh& mesh, const Eigen::VectorXd& x, const Camera& camera) {
  Eigen::Matrix2Xd p;
  EXPECT_TRUE(ProjectVertices(x, camera, &p));
  const auto& hem = mesh.boundary_loops[0];
  double area = 0;
  for (size_t i = 0; i < hem.size(); ++i) {
    const Eigen::Vector2d a = p.col(hem[i]), b = p.col(hem[(i + 1) % hem.size()]);
    area -= 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return area;
}

TEST(Rasterize, AreaIsThePolygonsArea) {
  const Mesh mesh = MakeDisc(5, 90, 0.15);
  const Eigen::VectorXd x = Deform(mesh, {});
  Camera pinhole;
  pinhole.kind = CameraKind::kPinhole;
  for (const Camera& camera : {Camera(), pinhole}) {
    const double exact = HemArea(mesh, x, camera);
    EXPECT_NEAR(Area(Rasterize(mesh, x, camera, 1)), exact, 2e-3 * exact);
    EXPECT_NEAR(Area(Rasterize(mesh, x, camera, 8)), exact, 1e-4 * exact);
  }
}

// Pixel centres lie exactly on shared edges and vertices of this mesh, where no hole may appear.
TEST(Rasterize, HasNoHolesOnSharedEdges) {
  for (int sectors : {8, 7, 48}) {
    const Mesh mesh = MakeDisc(6, sectors, 0.15);
    Camera camera;
    for (double centre : {127.5, 127.0, 127.1}) {
      camera.cx = camera.cy = centre;
      const GrayImage image = Rasterize(mesh, mesh.rest_x, camera);
      for (int row = 0; row < 256; ++row) {
        for (int col = 0; col < 256; ++col) {
          const bool inside =
              std::hypot(col - centre, row - centre) < 107.9 * std::cos(M_PI / sectors);
          ASSERT_TRUE(!inside || image.at(col, row) == 1) << col << ", " << row;
        }
      }
    }
  }
}

TEST(Rasterize, PixelCentresAreAtIntegers) {
  Mesh mesh = MakeDisc(1, 4, 1.0);
  Camera camera;
  camera.scale = 1;
  camera.cx = 10.5;
  camera.cy = 20.0;
  mesh.rest_x *= 0.9;  // |column − 10.5| + |row − 20| ≤ 0.9: the centres of (10, 20) and (11, 20)
  const GrayImage image = Rasterize(mesh, mesh.rest_x, camera);
  EXPECT_EQ(Area(image), 2);
  EXPECT_EQ(image.at(10, 20), 1);
  EXPECT_EQ(image.at(11, 20), 1);
}

TEST(Rasterize, ClothOutsideTheImageIsCutOff) {
  const Mesh mesh = MakeDisc(2, 60, 0.15);
  Camera camera;
  camera.scale = 1e7;
  EXPECT_EQ(Area(Rasterize(mesh, mesh.rest_x, camera)), 256 * 256);
}

}  // namespace
}  // namespace drape
