// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/outline.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "losses/silhouette/silhouette.h"
#include "tests/losses/disc.h"

namespace drape {
namespace {

Camera CameraForImage(CameraKind kind) {
  Camera camera;
  camera.kind = kind;
  return camera;
}

class OutlineOfMesh : public testing::TestWithParam<CameraKind> {
 protected:
  const Camera camera_ = CameraForImage(GetParam());
  const Mesh mesh_ = MakeDisc(5, 50, 0.15);
  // The noise moves the vertices off the rays, since r has different left and right derivatives on
  // a ray through a vertex.
  const Eigen::VectorXd x_ =
      Deform(mesh_, {.folds = 5, .twist = 0.1}) + 1e-3 * RandomVector(3 * mesh_.num_vertices(), 6);
};

// The radius of ray k through the projected segment, by the textbook formula and in dual numbers.
using Jet = ceres::Jet<double, 6>;
Jet RayHit(const Camera& camera, const Eigen::VectorXd& x, const OutlineHit& hit, double angle) {
  Jet q[2][2];
  for (int end = 0; end < 2; ++end) {
    Jet point[3];
    for (int i = 0; i < 3; ++i) point[i] = Jet(x[3 * hit.vertex[end] + i], 3 * end + i);
    camera.Project(point, q[end]);
    q[end][0] = q[end][0] - camera.cx;
    q[end][1] = camera.cy - q[end][1];
  }
  const Jet ex = q[1][0] - q[0][0], ey = q[1][1] - q[0][1];
  return (q[0][0] * ey - q[0][1] * ex) / (std::cos(angle) * ey - std::sin(angle) * ex);
}

TEST_P(OutlineOfMesh, JacobianAgreesWithDualNumbers) {
  const int num_angles = 72;
  Outline outline;
  ASSERT_TRUE(OutlineFromMesh(mesh_, x_, camera_, num_angles, &outline));
  for (int k = 0; k < num_angles; ++k) {
    const Jet r = RayHit(camera_, x_, outline.hits[k], 2 * M_PI * k / num_angles);
    EXPECT_NEAR(outline.radius[k], r.a, 1e-10);
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> d_radius(outline.hits[k].d_radius);
    EXPECT_LT((d_radius - r.v).norm(), 1e-9 * r.v.norm()) << "angle " << k;
  }
}

// The truncation error decreases with h, and the rounding error grows as 1e-13/h: the best step
// must be far better than 1e-7, and a step of 1e-5 m must agree to 1e-4.
TEST_P(OutlineOfMesh, JacobianAgreesWithFiniteDifferences) {
  Outline outline, plus, minus;
  ASSERT_TRUE(OutlineFromMesh(mesh_, x_, camera_, 180, &outline));
  const Eigen::VectorXd dx = RandomVector(x_.size(), 7);
  const Eigen::VectorXd exact = OutlineJacobian(outline, mesh_.num_vertices()) * dx;
  double best = 1;
  for (double h : {1e-5, 1e-6, 1e-7, 1e-8}) {
    ASSERT_TRUE(OutlineFromMesh(mesh_, x_ + h * dx, camera_, 180, &plus));
    ASSERT_TRUE(OutlineFromMesh(mesh_, x_ - h * dx, camera_, 180, &minus));
    const Eigen::VectorXd difference = (plus.radius - minus.radius) / (2 * h);
    const double error = (difference - exact).norm() / exact.norm();
    // At the largest step a few rays change their segment.
    EXPECT_LT(error, 2e-2) << "step " << h;
    best = std::min(best, error);
  }
  EXPECT_LT(best, 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Cameras, OutlineOfMesh,
                         testing::Values(CameraKind::kOrthographic, CameraKind::kPinhole));

TEST(OutlineFromMesh, CircleHasItsRadius) {
  const int sectors = 720;
  const Mesh disc = MakeDisc(2, sectors, 0.15);
  Outline outline;
  ASSERT_TRUE(OutlineFromMesh(disc, disc.rest_x, Camera(), 180, &outline));
  EXPECT_LT((outline.radius.array() - 107.925).abs().maxCoeff(), 1e-9);  // rays meet vertices
  ASSERT_TRUE(OutlineFromMesh(disc, disc.rest_x, Camera(), 160, &outline));
  EXPECT_LT((outline.radius.array() - 107.925).abs().maxCoeff(),
            107.925 * (1 - std::cos(M_PI / sectors)) + 1e-9);
}

// Rays exactly at the angles of the vertices: rounding must not let one pass between two segments.
TEST(OutlineFromMesh, RaysThroughVerticesAlwaysHit) {
  for (int sectors = 3; sectors < 200; ++sectors) {
    const Mesh disc = MakeDisc(1, sectors, 0.15);
    Outline outline;
    EXPECT_TRUE(OutlineFromMesh(disc, disc.rest_x, Camera(), sectors, &outline)) << sectors;
    EXPECT_NEAR(outline.radius.minCoeff(), 107.925, 1e-9) << sectors;
  }
}

TEST(OutlineFromMesh, TakesTheOutermostOfManyCrossings) {
  const Mesh disc = MakeDisc(1, 120, 0.15);
  const Eigen::VectorXd x = Deform(disc, {.folds = 4, .twist = 0.6});
  const int num_angles = 90;
  Outline outline;
  ASSERT_TRUE(OutlineFromMesh(disc, x, Camera(), num_angles, &outline));
  const auto& hem = disc.boundary_loops[0];
  int multiple = 0;
  for (int k = 0; k < num_angles; ++k) {
    const double angle = 2 * M_PI * k / num_angles;
    double outermost = 0;
    int count = 0;
    for (size_t i = 0; i < hem.size(); ++i) {
      OutlineHit segment;
      segment.vertex[0] = hem[i];
      segment.vertex[1] = hem[(i + 1) % hem.size()];
      const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d a = x.segment<2>(3 * segment.vertex[0]);
      const Eigen::Vector2d b = x.segment<2>(3 * segment.vertex[1]);
      const auto side = [&](const Eigen::Vector2d& p) { return ray.x() * p.y() - ray.y() * p.x(); };
      const double r = RayHit(Camera(), x, segment, angle).a;
      if ((side(a) > 0) == (side(b) > 0) || r <= 0) continue;
      ++count;
      outermost = std::max(outermost, r);
    }
    multiple += count > 1;
    EXPECT_NEAR(outline.radius[k], outermost, 1e-9);
  }
  EXPECT_GT(multiple, 10);  // confirms that the case has multiple crossings
}

TEST(OutlineFromMesh, ReportsRaysWithoutCloth) {
  const Mesh disc = MakeDisc(2, 40, 0.05);
  Eigen::VectorXd x = disc.rest_x;
  for (int i = 0; i < disc.num_vertices(); ++i) x[3 * i] += 0.08;  // right of the centre
  Outline outline;
  EXPECT_FALSE(OutlineFromMesh(disc, x, Camera(), 36, &outline));
  EXPECT_GT(outline.radius[0], 0);
  EXPECT_TRUE(outline.radius.allFinite());
  EXPECT_EQ(std::count(outline.missing.begin(), outline.missing.end(), 0), 0);
  EXPECT_EQ(std::count(outline.missing.begin(), outline.missing.end(), 18), 1);
  EXPECT_EQ(outline.hits[18].vertex[0], -1);
  EXPECT_EQ(OutlineJacobian(outline, disc.num_vertices()).row(18).nonZeros(), 0);
}

TEST(OutlineFromMesh, ReportsNonFinitePositions) {
  const Mesh disc = MakeDisc(2, 40, 0.15);
  Eigen::VectorXd x = disc.rest_x;
  x[3 * disc.boundary_loops[0][3]] = std::nan("");
  Outline outline;
  EXPECT_FALSE(OutlineFromMesh(disc, x, Camera(), 36, &outline));
  EXPECT_EQ(outline.missing.size(), 36u);
  EXPECT_TRUE(outline.radius.allFinite());
}

TEST(OutlineFromImage, FindsTheMeshOutlineInSoftAndHardImages) {
  const Mesh mesh = MakeDisc(6, 240, 0.15);
  const Eigen::VectorXd x = Deform(mesh, {.folds = 6});
  Outline exact, measured;
  ASSERT_TRUE(OutlineFromMesh(mesh, x, Camera(), 180, &exact));
  ASSERT_TRUE(OutlineFromImage(Rasterize(mesh, x, Camera(), 8), Camera(), 180, &measured));
  EXPECT_LT((exact.radius - measured.radius).cwiseAbs().maxCoeff(), 0.25);
  EXPECT_LT(std::abs((exact.radius - measured.radius).mean()), 0.02);
  ASSERT_TRUE(OutlineFromImage(Rasterize(mesh, x, Camera(), 1), Camera(), 180, &measured));
  EXPECT_LT((exact.radius - measured.radius).cwiseAbs().maxCoeff(), 0.8);
  EXPECT_LT(std::abs((exact.radius - measured.radius).mean()), 0.06);
  EXPECT_TRUE(measured.hits.empty());
}

TEST(OutlineFromImage, ThetaRunsCounterClockwiseFromTheRight) {
  GrayImage image(256, 256);
  for (int row = 50; row < 140; ++row) {
    for (int col = 120; col < 140; ++col) image.at(col, row) = 1;  // a bar that points up
  }
  Outline outline;
  ASSERT_TRUE(OutlineFromImage(image, Camera(), 4, &outline));
  EXPECT_NEAR(outline.radius[0], 12, 0.01);  // right: to column 139.5
  EXPECT_NEAR(outline.radius[1], 78, 0.01);  // up: to row 49.5
  EXPECT_NEAR(outline.radius[2], 8, 0.01);   // left: to column 119.5
  EXPECT_NEAR(outline.radius[3], 12, 0.01);  // down: to row 139.5
}

TEST(OutlineFromImage, ReportsRaysWithoutCloth) {
  GrayImage image(256, 256);
  image.at(200, 127) = image.at(200, 128) = image.at(201, 127) = image.at(201, 128) = 1;
  Outline outline;
  EXPECT_FALSE(OutlineFromImage(image, Camera(), 4, &outline));
  EXPECT_EQ(outline.missing, (std::vector<int>{1, 2, 3}));
}

// A star of 7 folds with an ellipse, without a first harmonic about (column, row). The coverage
// falls from 1 to 0 over the pixel that the outline crosses.
GrayImage Star(double column, double row) {
  GrayImage image(256, 256);
  for (int j = 0; j < image.height; ++j) {
    for (int i = 0; i < image.width; ++i) {
      const double x = i - column, y = row - j, angle = std::atan2(y, x);
      const double radius =
          80.0 + 9.0 * std::cos(7 * angle + 0.4) + 5.0 * std::cos(2 * angle - 1.0);
      image.at(i, j) = static_cast<float>(std::clamp(radius - std::hypot(x, y) + 0.5, 0.0, 1.0));
    }
  }
  return image;
}

class CentreTest : public testing::TestWithParam<std::pair<double, double>> {};
INSTANTIATE_TEST_SUITE_P(Offsets, CentreTest,
                         testing::Values(std::pair{0.0, 0.0}, std::pair{9.5, 0.0},
                                         std::pair{0.0, -7.25}, std::pair{-6.3, 8.1}));

TEST_P(CentreTest, FindsAKnownOffset) {
  const auto [along, down] = GetParam();
  Camera camera;
  const Camera nominal;
  ASSERT_TRUE(CentreOnOutline(Star(nominal.cx + along, nominal.cy + down), &camera));
  EXPECT_NEAR(camera.cx - nominal.cx, along, 0.05);
  EXPECT_NEAR(camera.cy - nominal.cy, down, 0.05);
  EXPECT_EQ(camera.scale, nominal.scale);
}

TEST(Centre, LeavesNoFirstHarmonic) {
  const GrayImage image = Star(134.0, 121.0);
  Camera camera;
  ASSERT_TRUE(CentreOnOutline(image, &camera));
  Outline outline;
  ASSERT_TRUE(OutlineFromImage(image, camera, 360, &outline));
  double along = 0.0, up = 0.0;
  for (int k = 0; k < 360; ++k) {
    along += outline.radius[k] * std::cos(2 * M_PI * k / 360) / 180;
    up += outline.radius[k] * std::sin(2 * M_PI * k / 360) / 180;
  }
  EXPECT_LT(std::hypot(along, up), 1e-3);
}

TEST(Centre, AnImageWithoutClothHasNone) {
  Camera camera;
  EXPECT_FALSE(CentreOnOutline(GrayImage(256, 256), &camera));
}

TEST(EstimatedHemHeight, IsThatOfAHangingAndOfAFlatCloth) {
  EXPECT_DOUBLE_EQ(EstimatedHemHeight(0.09, {}), -0.06);
  EXPECT_DOUBLE_EQ(EstimatedHemHeight(0.15, {}), 0.0);
  EXPECT_NEAR(EstimatedHemHeight(0.12, {}), -0.06 * std::sqrt(0.9775 * 0.9775 - 0.25), 1e-12);
  EXPECT_NEAR(EstimatedHemHeight(0.12, {0.18, 0.09}), -0.0842, 2e-3);
}

// Straight above the axis at 1 m, where a point at the height z is seen at radius·(1 − z/1 m).
TEST(EstimatedOutermost, IsTheHemFarFromTheSupportAndBetweenItAndTheBendNearIt) {
  const auto seen_at = [](double radius, double height) {
    const double at_support = radius / (1 - height);
    return [at_support](double z) { return Eigen::Vector2d(at_support * (1 - z), 0.0); };
  };
  for (const double radius : {0.11, 0.13, 0.15}) {
    const auto point_at = seen_at(radius, EstimatedHemHeight(radius, {}));
    EXPECT_NEAR(EstimatedOutermost(point_at, {}).x(), radius, 1e-5) << radius;
  }
  const double rim = 0.09;
  const Eigen::Vector2d found = EstimatedOutermost(seen_at(rim, 0.0), {});
  EXPECT_GT(found.x(), rim);
  EXPECT_LT(found.x(), rim * (1 - EstimatedHemHeight(rim, {})));
  EXPECT_NEAR(EstimatedOutermost(seen_at(1.02 * rim, 0.0), {}).x(), 1.02 * rim * 1.0117, 1e-4);
}

// A hem that hangs exactly at the estimated heights is found again.
TEST(VerticalProfile, UndoesAnObliquePinhole) {
  Camera camera;
  camera.kind = CameraKind::kPinhole;
  camera.width = 1200;
  camera.height = 1000;
  camera.cx = 640;
  camera.cy = 510;
  camera.eye_height = 1.0;
  camera.eye_x = 0.08;
  camera.eye_y = -0.05;
  constexpr int kAngles = 360, kFine = 3600;
  const auto radius = [](double angle) { return 0.12 + 0.012 * std::cos(7 * angle + 0.4); };
  Eigen::VectorXd seen = Eigen::VectorXd::Zero(kAngles);
  Eigen::Matrix2Xd points(2, kFine);
  for (int i = 0; i < kFine; ++i) {
    const double angle = 2 * M_PI * i / kFine, r = radius(angle);
    const double x[3] = {r * std::cos(angle), r * std::sin(angle), EstimatedHemHeight(r, {})};
    camera.Project(x, points.col(i).data());
  }
  for (int i = 0; i < kFine; ++i) {
    const double angle = std::atan2(camera.cy - points(1, i), points(0, i) - camera.cx);
    const int k = static_cast<int>(std::lround(angle / (2 * M_PI) * kAngles) + kAngles) % kAngles;
    if (std::abs(std::remainder(angle - 2 * M_PI * k / kAngles, 2 * M_PI)) < M_PI / kFine)
      seen[k] = std::hypot(points(0, i) - camera.cx, points(1, i) - camera.cy);
  }
  for (int k = 0; k < kAngles; ++k)
    if (seen[k] == 0) seen[k] = seen[(k + kAngles - 1) % kAngles];
  const Eigen::VectorXd found = VerticalProfile(seen, camera, {});
  const Eigen::VectorXd plane = MetresFromPixels(seen, camera);
  double worst = 0;
  for (int k = 0; k < kAngles; ++k)
    worst = std::max(worst, std::abs(found[k] - radius(2 * M_PI * k / kAngles)));
  EXPECT_LT(worst, 2.5e-3);
  EXPECT_NEAR(ProfileArea(found), M_PI * (0.12 * 0.12 + 0.5 * 0.012 * 0.012), 2e-4);
  EXPECT_LT(ProfileArea(plane), 0.95 * ProfileArea(found));
}

}  // namespace
}  // namespace drape
