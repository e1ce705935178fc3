// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/view_readouts.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numeric>
#include <tuple>

#include "tests/losses/disc.h"
#include "tests/losses/readout/differences.h"

namespace drape {
namespace {

using Eigen::Vector3d;

std::vector<int> AllPixels(const Camera& camera) {
  std::vector<int> pixels(size_t(camera.width) * camera.height);
  std::iota(pixels.begin(), pixels.end(), 0);
  return pixels;
}

int PixelAt(const Camera& camera, int column, int row) { return row * camera.width + column; }

Camera MakeCamera(CameraKind kind) {
  Camera camera;
  camera.kind = kind;
  camera.width = camera.height = 96;
  camera.cx = camera.cy = 47.3;
  camera.scale = 270.0;
  return camera;
}

class ViewReadoutsTest : public testing::TestWithParam<std::tuple<CameraKind, bool>> {
 protected:
  ViewReadoutsTest() : view_(MakeCamera(std::get<0>(GetParam()))) {
    if (std::get<1>(GetParam()))
      view_ = LookAt(view_.camera, {0.3, -0.6, 0.1}, {0.0, 0.0, -0.05}, Vector3d::UnitZ(), "view");
  }
  const Mesh mesh_ = MakeDisc(8, 50, 0.15);
  const Eigen::VectorXd x_ =
      Deform(mesh_, {.folds = 5, .twist = 0.4}) + 1e-3 * RandomVector(3 * mesh_.num_vertices(), 6);
  View view_;
};

TEST_P(ViewReadoutsTest, SilhouetteHasTheDerivativeOfDifferences) {
  test::ExpectDerivative(SilhouetteReadout(mesh_, view_, {1.5}), x_, 2e-5, 1e-8);
}

TEST_P(ViewReadoutsTest, DepthHasTheDerivativeOfDifferences) {
  const double background = 1.5;
  const DepthReadout readout(mesh_, view_, AllPixels(view_.camera), background);
  test::ExpectDerivative(readout, x_, 1e-5, 1e-9);
  Eigen::VectorXd r;
  ASSERT_TRUE(readout.Read(x_, &r, nullptr));
  EXPECT_GT((r.array() < background).count(), 1000);
  EXPECT_GT((r.array() == background).count(), 1000);
}

TEST_P(ViewReadoutsTest, DepthIsOfTheFirstFaceOnEachRay) {
  const DepthReadout readout(mesh_, view_, AllPixels(view_.camera), 1.5);
  Eigen::VectorXd r;
  ASSERT_TRUE(readout.Read(x_, &r, nullptr));
  for (int pixel = 0; pixel < r.size(); pixel += 7) {
    const Eigen::Vector2d image(pixel % view_.camera.width, pixel / view_.camera.width);
    const Vector3d near = view_.WorldFromImage(image, 1.0);
    const Vector3d along = view_.WorldFromImage(image, 2.0) - near, from = near - along;
    double first = 1.5;
    for (const Face& face : mesh_.faces) {
      Eigen::Matrix3d system;  // from + t·along = a + u·(b − a) + v·(c − a)
      const Vector3d a = x_.segment<3>(3 * face.vertex[0]);
      system << -along, x_.segment<3>(3 * face.vertex[1]) - a,
          x_.segment<3>(3 * face.vertex[2]) - a;
      const Vector3d tuv = system.inverse() * (from - a);
      if (tuv[1] > 0 && tuv[2] > 0 && tuv[1] + tuv[2] < 1) first = std::min(first, tuv[0]);
    }
    EXPECT_NEAR(r[pixel], first, 1e-9) << pixel;
  }
}

TEST_P(ViewReadoutsTest, RefusesShapesThatAreNotFiniteOrBehindTheEye) {
  const SilhouetteReadout silhouette(mesh_, view_, {1.5});
  const DepthReadout depth(mesh_, view_, {5}, 1.0);
  Eigen::VectorXd r, x = x_;
  x[5] = std::nan("");
  EXPECT_FALSE(silhouette.Read(x, &r, nullptr));
  EXPECT_FALSE(depth.Read(x, &r, nullptr));
  if (!view_.camera.is_pinhole()) return;
  for (int i = 0; i < x.size(); i += 3)
    x.segment<3>(i) = x_.segment<3>(i) + view_.turn.transpose() * Vector3d(0, 0, 1.0);
  EXPECT_FALSE(silhouette.Read(x, &r, nullptr));
  EXPECT_FALSE(depth.Read(x, &r, nullptr));
}

INSTANTIATE_TEST_SUITE_P(CamerasAboveAndAside, ViewReadoutsTest,
                         testing::Combine(testing::Values(CameraKind::kOrthographic,
                                                          CameraKind::kPinhole),
                                          testing::Bool()));

class StandingSheetTest : public testing::TestWithParam<CameraKind> {};

// A disc that stands in the plane y = 0.1 m, 0.7 m before the camera.
TEST_P(StandingSheetTest, ShowsItsAreaAndItsDistance) {
  const Mesh mesh = MakeDisc(3, 60, 0.1);
  Eigen::VectorXd x = Eigen::VectorXd::Constant(mesh.rest_x.size(), 0.1);
  for (int i = 0; i < mesh.num_vertices(); ++i) {
    x[3 * i] = mesh.uv(0, i);
    x[3 * i + 2] = mesh.uv(1, i);
  }
  const View view =
      LookAt(MakeCamera(GetParam()), {0, -0.6, 0}, {0, 0, 0}, Vector3d::UnitZ(), "view");
  const Camera& camera = view.camera;
  Eigen::VectorXd r;
  ASSERT_TRUE(SilhouetteReadout(mesh, view, {1.0}).Read(x, &r, nullptr));
  const double scale = camera.PixelsPerMetre(DepthOrigin(camera) - 0.7);
  const double area = 0.5 * 60 * std::sin(2 * M_PI / 60) * 0.01 * scale * scale;
  EXPECT_NEAR(r.sum(), area, 2e-3 * area);
  const std::vector<int> pixels = {PixelAt(camera, 47, 47), PixelAt(camera, 60, 40),
                                   PixelAt(camera, 0, 0)};
  ReadoutJacobian jacobian;
  ASSERT_TRUE(DepthReadout(mesh, view, pixels, 2.0).Read(x, &r, &jacobian));
  EXPECT_NEAR(r[0], 0.7, 1e-12);
  EXPECT_NEAR(r[1], 0.7, 1e-12);
  EXPECT_EQ(r[2], 2.0);
  Eigen::VectorXd away = Eigen::VectorXd::Zero(x.size());
  for (int i = 1; i < x.size(); i += 3) away[i] = 1.0;
  EXPECT_LT((jacobian * away - Vector3d(1, 1, 0)).norm(), 1e-12);
}

// Folded over the line x = 0: one half at z = 0, the other one above it, at z = 5 cm.
TEST_P(StandingSheetTest, TheUpperLayerIsSeenFromAboveAndTheLowerOneFromBelow) {
  const Mesh mesh = MakeDisc(6, 60, 0.1);
  Eigen::VectorXd x = mesh.rest_x;
  for (int i = 0; i < mesh.num_vertices(); ++i)
    if (x[3 * i] < 0) x.segment<3>(3 * i) << -x[3 * i], x[3 * i + 1], 0.05;
  const Camera camera = MakeCamera(GetParam());
  const std::vector<int> pixels = {PixelAt(camera, 60, 47)};
  Eigen::VectorXd r;
  ASSERT_TRUE(DepthReadout(mesh, camera, pixels, 2.0).Read(x, &r, nullptr));
  EXPECT_NEAR(r[0], DepthOrigin(camera) - 0.05, 1e-12);
  const View below = LookAt(camera, {0, 0, -0.6}, {0, 0, 0}, {0, 1, 0}, "view");
  ASSERT_TRUE(DepthReadout(mesh, below, {PixelAt(camera, 34, 47)}, 2.0).Read(x, &r, nullptr));
  EXPECT_NEAR(r[0], 0.6, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Cameras, StandingSheetTest,
                         testing::Values(CameraKind::kOrthographic, CameraKind::kPinhole));

}  // namespace
}  // namespace drape
