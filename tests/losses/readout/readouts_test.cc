// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/readouts.h"

#include <gtest/gtest.h>

#include "losses/outline/outline.h"
#include "tests/losses/disc.h"
#include "tests/losses/silhouette/adj_render_soft.h"

namespace drape {
namespace {

class ReadoutsTest : public testing::TestWithParam<CameraKind> {
 protected:
  ReadoutsTest() {
    camera_.kind = GetParam();
    camera_.cx += 3.0;
  }
  const Mesh mesh_ = MakeDisc(5, 50, 0.15);
  const Eigen::VectorXd x_ =
      Deform(mesh_, {.folds = 5, .twist = 0.4}) + 1e-3 * RandomVector(3 * mesh_.num_vertices(), 6);
  Camera camera_;
};

TEST_P(ReadoutsTest, OutlineIsThatOfItsCamera) {
  const OutlineReadout readout(mesh_, camera_, 72);
  ASSERT_EQ(readout.size(), 72);
  Outline outline;
  ASSERT_TRUE(OutlineFromMesh(mesh_, x_, camera_, 72, &outline));
  Eigen::VectorXd r;
  ReadoutJacobian jacobian;
  ASSERT_TRUE(readout.Read(x_, &r, &jacobian));
  EXPECT_EQ(r, outline.radius);
  EXPECT_EQ(Eigen::MatrixXd(jacobian),
            Eigen::MatrixXd(OutlineJacobian(outline, mesh_.num_vertices())));
  EXPECT_FALSE(readout.Read(x_.array() + 1.0, &r, nullptr));
}

TEST_P(ReadoutsTest, SilhouetteIsTheSoftCoverageAndItsTransposeTheAdjoint) {
  const SilhouetteReadout readout(mesh_, camera_, {1.5});
  SoftSilhouette soft;
  ASSERT_TRUE(RenderSoft(mesh_, x_, camera_, {1.5}, &soft));
  Eigen::VectorXd r;
  ReadoutJacobian jacobian;
  ASSERT_TRUE(readout.Read(x_, &r, &jacobian));
  ASSERT_EQ(r.size(), readout.size());
  EXPECT_EQ(r, soft.coverage);
  const Eigen::VectorXd weights = RandomVector(r.size(), 8);
  Eigen::VectorXd adjoint = Eigen::VectorXd::Zero(x_.size());
  test::AdjRenderSoft(soft, x_, camera_, weights, &adjoint);
  EXPECT_LT((jacobian.transpose() * weights - adjoint).norm(), 1e-12 * adjoint.norm());
  Eigen::VectorXd x = x_;
  x[5] = std::nan("");
  EXPECT_FALSE(readout.Read(x, &r, nullptr));
}

// In metres, whatever camera sees the drape.
TEST(FeatureReadoutTest, IsMeasureShapeWithItsDerivative) {
  const Mesh mesh = MakeDisc(5, 50, 0.15);
  const Eigen::VectorXd x =
      Deform(mesh, {.folds = 5, .twist = 0.4}) + 1e-3 * RandomVector(3 * mesh.num_vertices(), 6);
  const DrapeDiscs discs;
  const Camera above = CameraAbove(discs);
  const FeatureReadout readout(mesh, discs);
  ASSERT_EQ(readout.size(), kNumShapeFeatures);
  Outline outline;
  ASSERT_TRUE(OutlineFromMesh(mesh, x, above, 360, &outline));
  const ShapeFeatures shape = MeasureShape(MetresFromPixels(outline.radius, above), discs);
  Eigen::VectorXd r, plus, minus;
  ReadoutJacobian jacobian;
  ASSERT_TRUE(readout.Read(x, &r, &jacobian));
  EXPECT_EQ(r, ListShapeFeatures(shape));
  EXPECT_EQ(r[0], shape.drape_coefficient);
  EXPECT_EQ(r[1], 5.0);
  EXPECT_STREQ(kShapeFeatureNames[8], "isoperimetric_ratio");
  EXPECT_EQ(r[8], shape.isoperimetric_ratio);
  const Eigen::VectorXd direction = RandomVector(static_cast<int>(x.size()), 9);
  const double h = 1e-7;
  ASSERT_TRUE(readout.Read(x + h * direction, &plus, nullptr));
  ASSERT_TRUE(readout.Read(x - h * direction, &minus, nullptr));
  const Eigen::VectorXd found = jacobian * direction, differences = (plus - minus) / (2 * h);
  for (int k = 0; k < kNumShapeFeatures; ++k) {
    EXPECT_NEAR(found[k], differences[k], 1e-6 * jacobian.row(k).norm() * direction.norm())
        << kShapeFeatureNames[k];
    EXPECT_EQ(jacobian.row(k).norm() > 0.0, k != 1) << kShapeFeatureNames[k];
  }
  EXPECT_FALSE(readout.Read(x.array() + 1.0, &r, nullptr));
}

INSTANTIATE_TEST_SUITE_P(Cameras, ReadoutsTest,
                         testing::Values(CameraKind::kOrthographic, CameraKind::kPinhole));

}  // namespace
}  // namespace drape
