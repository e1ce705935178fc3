// SPDX-License-Identifier: Apache-2.0
#include "losses/silhouette/silhouette.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "tests/losses/disc.h"
#include "tests/losses/silhouette/adj_render_soft.h"

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

// Triangles of all forms, also flat and narrow ones and those that leave the image.
TEST(Rasterize, CoversThePixelsInATriangle) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(-60.0, 320.0);
  Camera camera;
  camera.scale = 1.0;
  camera.cx = camera.cy = 0.0;
  for (int k = 0; k < 200; ++k) {
    Eigen::Matrix<double, 2, 3> p = Eigen::Matrix<double, 2, 3>::NullaryExpr(
        [&](Eigen::Index, Eigen::Index) { return place(random); });
    if (k % 4 == 0) p(1, 1) = p(1, 0) + (k % 8 == 0 ? 0.0 : 1e-4);
    if (k % 4 == 1) p.col(2) = 0.3 * p.col(0) + 0.7 * p.col(1) + Eigen::Vector2d(0.4, 0.1);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(9);
    for (int i = 0; i < 3; ++i) x.segment<2>(3 * i) << p(0, i), -p(1, i);
    const GrayImage image = Rasterize(ObjSurface{.x = x, .triangles = {{0, 1, 2}}}, camera, 1);
    for (int row = 0; row < image.height; ++row)
      for (int col = 0; col < image.width; ++col) {
        double inside = 1e3, outside = 1e3;  // least distance from an edge [px]
        for (int i = 0; i < 3; ++i) {
          const Eigen::Vector2d edge = p.col((i + 1) % 3) - p.col(i);
          const Eigen::Vector2d to = Eigen::Vector2d(col, row) - p.col(i);
          const double side = (edge.x() * to.y() - edge.y() * to.x()) / edge.norm();
          inside = std::min(inside, side);
          outside = std::min(outside, -side);
        }
        const double depth = std::max(inside, outside);
        if (std::abs(depth) < 1e-9) continue;
        ASSERT_EQ(image.at(col, row), depth > 0.0 ? 1.0f : 0.0f) << k << " " << col << " " << row;
      }
  }
}

TEST(Rasterize, ClothOutsideTheImageIsCutOff) {
  const Mesh mesh = MakeDisc(2, 60, 0.15);
  Camera camera;
  camera.scale = 1e7;
  EXPECT_EQ(Area(Rasterize(mesh, mesh.rest_x, camera)), 256 * 256);
}

struct Case {
  const char* name;
  CameraKind kind;
  DrapeShape shape;
  double half_width;
};
void PrintTo(const Case& c, std::ostream* stream) { *stream << c.name; }

class SoftSilhouetteOfShape : public testing::TestWithParam<Case> {
 protected:
  SoftSilhouetteOfShape() {
    camera_.kind = GetParam().kind;
    // A small random shift moves the symmetric shape away from ties and from the pixel lattice.
    x_ = Deform(mesh_, GetParam().shape) + 1e-3 * RandomVector(3 * mesh_.num_vertices(), 5);
  }
  SoftSilhouette Render(const Eigen::VectorXd& x) const {
    SoftSilhouette soft;
    EXPECT_TRUE(RenderSoft(mesh_, x, camera_, {GetParam().half_width}, &soft));
    return soft;
  }

  const Mesh mesh_ = MakeDisc(6, 60, 0.15);
  Camera camera_;
  Eigen::VectorXd x_;
};

// The ramp is C1 in the distance, but a pixel whose nearest edge changes within the step adds an
// error of order h: the error must decrease with h until rounding (1e-12/h) dominates.
TEST_P(SoftSilhouetteOfShape, AdjointAgreesWithFiniteDifferences) {
  const SoftSilhouette soft = Render(x_);
  const Eigen::VectorXd weights = RandomVector(soft.coverage.size(), 11);
  const Eigen::VectorXd dx = RandomVector(x_.size(), 12);
  Eigen::VectorXd gradient =
      Eigen::VectorXd::Constant(x_.size(), 3.0);  // AdjRenderSoft must add to it
  test::AdjRenderSoft(soft, x_, camera_, weights, &gradient);
  const double exact = (gradient.array() - 3.0).matrix().dot(dx);
  const double scale = (gradient.array() - 3.0).matrix().norm();
  double best = 1;
  for (double h : {1e-5, 1e-6, 1e-7, 1e-8, 1e-9}) {
    const Eigen::VectorXd change = Render(x_ + h * dx).coverage - Render(x_ - h * dx).coverage;
    const double error = std::abs(weights.dot(change) / (2 * h) - exact) / scale;
    EXPECT_LT(error, 0.05) << "step " << h;
    best = std::min(best, error);
  }
  EXPECT_LT(best, 1e-6);
}

TEST_P(SoftSilhouetteOfShape, AgreesWithTheRasterInAreaAndAwayFromTheBorder) {
  const double half_width = GetParam().half_width;
  const SoftSilhouette soft = Render(x_);
  const GrayImage hard = Rasterize(mesh_, x_, camera_, 8);
  const Eigen::Map<const Eigen::VectorXf> raster(hard.coverage.data(), hard.coverage.size());
  const double area = raster.cast<double>().sum();
  EXPECT_NEAR(soft.coverage.sum(), area, 1e-3 * (1 + half_width) * area);
  for (Eigen::Index i = 0; i < soft.coverage.size(); ++i) {
    const double c = soft.coverage[i];
    EXPECT_TRUE((c > 0 && c < 1) || c == hard.coverage[i]) << "pixel " << i;
  }
}

constexpr auto kOrtho = CameraKind::kOrthographic;
constexpr auto kPin = CameraKind::kPinhole;
const DrapeShape kPlain = {.folds = 6};
// The hem turns back on itself in the image: folds cover folds, and their edges cross.
const DrapeShape kOverlap = {.folds = 5, .amplitude = 0.2, .twist = 0.5};
INSTANTIATE_TEST_SUITE_P(Shapes, SoftSilhouetteOfShape,
                         testing::Values(Case{"plain", kOrtho, kPlain, 1.0},
                                         Case{"plain_wide", kOrtho, kPlain, 2.5},
                                         Case{"plain_pinhole", kPin, kPlain, 1.0},
                                         Case{"overlap", kOrtho, kOverlap, 1.0},
                                         Case{"overlap_wide", kOrtho, kOverlap, 2.5},
                                         Case{"overlap_pinhole", kPin, kOverlap, 1.5}),
                         [](const auto& info) { return info.param.name; });

// The signed distance in closed form: the coverage of a circle and its derivative by a common scale
// of x.
TEST(RenderSoft, CircleInClosedForm) {
  const Mesh disc = MakeDisc(3, 1000, 0.15);
  const Camera camera;
  SoftSilhouette soft;
  ASSERT_TRUE(RenderSoft(disc, disc.rest_x, camera, {4.0}, &soft));
  const double radius = 0.15 * camera.scale;
  for (Eigen::Index i = 0; i < soft.coverage.size(); ++i) {
    const double distance = radius - std::hypot(i % 256 - 127.5, i / 256 - 127.5);
    const double u = std::clamp(0.5 + 0.125 * distance, 0.0, 1.0);
    EXPECT_NEAR(soft.coverage[i], u * u * (3 - 2 * u), 1e-3) << "pixel " << i;
  }
  // dA/ds of A = π(s·r)² at s = 1. The sum over the pixels is a quadrature of the slope of the
  // ramp: its error is 4e-5 at this width, 4e-3 at a half-width of 1 px.
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(disc.rest_x.size());
  test::AdjRenderSoft(soft, disc.rest_x, camera, Eigen::VectorXd::Ones(256 * 256), &gradient);
  EXPECT_NEAR(gradient.dot(disc.rest_x), 2 * M_PI * radius * radius, 1e-3 * radius * radius);
}

// The cloth turns under itself below the widest ring: the outline is an inner ring.
TEST(RenderSoft, AFoldThatHangsOverTheHemIsTheSilhouette) {
  const Mesh disc = MakeDisc(6, 90, 0.15);
  Eigen::VectorXd x = disc.rest_x;
  for (int j = 0; j < 90; ++j) {
    const int hem = disc.boundary_loops[0][j];
    x.segment<2>(3 * hem) *= 0.5;
    x[3 * hem + 2] = -0.05;
  }
  SoftSilhouette soft;
  ASSERT_TRUE(RenderSoft(disc, x, Camera(), {}, &soft));
  const double ring = 0.125 * 719.5;  // ring 5 of 6
  EXPECT_NEAR(soft.coverage.sum(), 45 * std::sin(2 * M_PI / 90) * ring * ring, 0.5);
  // The hem is hidden: there is no ramp inside the cloth and no derivative by the hem.
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(x.size());
  test::AdjRenderSoft(soft, x, Camera(), Eigen::VectorXd::Ones(256 * 256), &gradient);
  for (int hem : disc.boundary_loops[0]) EXPECT_EQ(gradient.segment<3>(3 * hem).norm(), 0);
  EXPECT_GT(gradient.norm(), 0);
}

TEST(FindSilhouetteEdges, OverlappingFoldsCrossAndLoseTheirHiddenParts) {
  const Mesh mesh = MakeDisc(6, 60, 0.15);
  const Eigen::VectorXd x = Deform(mesh, kOverlap) + 1e-3 * RandomVector(3 * 361, 5);
  Eigen::Matrix2Xd points;
  ASSERT_TRUE(ProjectVertices(x, Camera(), &points));
  const SilhouetteEdges edges = FindSilhouetteEdges(mesh, points);
  EXPECT_GE(edges.crossings.size(), 10u);
  // The pieces form closed curves: each end of a piece is met by that of another one.
  std::map<std::pair<double, double>, int> ends;
  for (const SilhouettePiece& piece : edges.pieces) {
    for (int end = 0; end < 2; ++end) {
      Eigen::Vector2d p = points.col(piece.vertex[end]);
      if (piece.crossing[end] >= 0) {
        const EdgeCrossing& c = edges.crossings[piece.crossing[end]];
        p = (1 - c.t[0]) * points.col(c.vertex[0]) + c.t[0] * points.col(c.vertex[1]);
      }
      ++ends[{p.x(), p.y()}];
    }
  }
  for (const auto& [point, count] : ends) EXPECT_EQ(count % 2, 0) << point.first;
}

TEST(RenderSoft, ReportsNonFinitePositions) {
  const Mesh disc = MakeDisc(2, 30, 0.15);
  Eigen::VectorXd x = disc.rest_x;
  x[4] = std::nan("");
  SoftSilhouette soft;
  EXPECT_FALSE(RenderSoft(disc, x, Camera(), {}, &soft));
}

TEST(RenderSoft, ClothFarOutsideTheImageIsCheap) {
  const Mesh disc = MakeDisc(4, 60, 0.15);
  SoftSilhouette soft;
  const Eigen::VectorXd x = 1e7 * (disc.rest_x + Eigen::VectorXd::Ones(disc.rest_x.size()));
  ASSERT_TRUE(RenderSoft(disc, x, Camera(), {}, &soft));
  EXPECT_EQ(soft.coverage.sum(), 0);
}

}  // namespace
}  // namespace drape
