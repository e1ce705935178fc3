// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/space/layout.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

namespace drape {
namespace {

// The points of a cluster.
std::vector<int> Leaves(const std::vector<ClusterMerge>& tree, int points, int cluster) {
  if (cluster < points) return {cluster};
  const ClusterMerge& merge = tree[cluster - points];
  std::vector<int> leaves = Leaves(tree, points, merge.left);
  for (const int leaf : Leaves(tree, points, merge.right)) leaves.push_back(leaf);
  return leaves;
}

}  // namespace

std::vector<ClusterMerge> AverageLinkage(const Eigen::MatrixXd& distances) {
  const int n = static_cast<int>(distances.rows());
  std::vector<ClusterMerge> tree;
  std::vector<int> open(n);
  for (int i = 0; i < n; ++i) open[i] = i;
  while (open.size() > 1) {
    ClusterMerge next{.height = std::numeric_limits<double>::infinity()};
    for (std::size_t a = 0; a < open.size(); ++a)
      for (std::size_t b = a + 1; b < open.size(); ++b) {
        const std::vector<int> left = Leaves(tree, n, open[a]), right = Leaves(tree, n, open[b]);
        double sum = 0.0;
        for (const int i : left)
          for (const int j : right) sum += distances(i, j);
        const double mean = sum / double(left.size() * right.size());
        if (mean < next.height) next = {open[a], open[b], mean};
      }
    std::erase_if(open, [&](int c) { return c == next.left || c == next.right; });
    tree.push_back(next);
    open.push_back(n + static_cast<int>(tree.size()) - 1);
  }
  return tree;
}

std::vector<int> LeafOrder(const std::vector<ClusterMerge>& tree) {
  const int n = static_cast<int>(tree.size()) + 1;
  return Leaves(tree, n, n == 1 ? 0 : 2 * n - 2);
}

Eigen::MatrixXd ScaleToPlane(const Eigen::MatrixXd& distances) {
  const Eigen::Index n = distances.rows();
  const Eigen::MatrixXd centring =
      Eigen::MatrixXd::Identity(n, n) - Eigen::MatrixXd::Constant(n, n, 1.0 / double(n));
  const Eigen::MatrixXd products = -0.5 * centring * distances.cwiseAbs2() * centring;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(products);
  Eigen::MatrixXd plane = Eigen::MatrixXd::Zero(n, 2);
  for (Eigen::Index k = 0; k < std::min<Eigen::Index>(2, n); ++k) {
    const Eigen::VectorXd axis = axes.eigenvectors().col(n - 1 - k);
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    const double sign = axis[largest] < 0 ? -1.0 : 1.0;
    plane.col(k) = sign * std::sqrt(std::max(0.0, axes.eigenvalues()[n - 1 - k])) * axis;
  }
  return plane;
}

}  // namespace drape
