// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/layout.h"

#include <gmock/gmock.h>

#include "solver/posterior/variational/gaussian_posterior.h"

namespace drape::test {
namespace {

Eigen::MatrixXd Distances(const Eigen::MatrixXd& points) {
  const Eigen::Index n = points.rows();
  Eigen::MatrixXd distances(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) distances(i, j) = (points.row(i) - points.row(j)).norm();
  return distances;
}

TEST(Layout, PointsOfAPlaneKeepTheirDistances) {
  const Eigen::MatrixXd distances = Distances(IndependentSamples(7, 2, 1));
  EXPECT_LT((Distances(ScaleToPlane(distances)) - distances).norm(), 1e-12);
  EXPECT_EQ(ScaleToPlane(Eigen::MatrixXd::Zero(1, 1)).rows(), 1);
}

// 0, 1, 5, 6.5: two pairs, of mean distance 5.25.
TEST(Layout, TreeByAverageLinkage) {
  const Eigen::Vector4d places(0, 5, 1, 6.5);
  const std::vector<ClusterMerge> tree = AverageLinkage(Distances(places));
  ASSERT_EQ(tree.size(), 3u);
  EXPECT_EQ(tree[0].left, 0);
  EXPECT_EQ(tree[0].right, 2);
  EXPECT_DOUBLE_EQ(tree[0].height, 1.0);
  EXPECT_DOUBLE_EQ(tree[1].height, 1.5);
  EXPECT_DOUBLE_EQ(tree[2].height, 5.25);
  EXPECT_THAT(LeafOrder(tree), testing::ElementsAre(0, 2, 1, 3));
  EXPECT_THAT(LeafOrder({}), testing::ElementsAre(0));
}

}  // namespace
}  // namespace drape::test
