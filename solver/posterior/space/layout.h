// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace drape {

// Pictures of a matrix of distances, symmetric with a zero diagonal, shape [n, n].

// Two clusters that become one. Clusters 0 … n − 1 are the points, n + k is that of merge k.
struct ClusterMerge {
  int left = 0, right = 0;
  double height = 0.0;  // their distance
};

// A tree by average linkage [Sokal 1958]: the two clusters with the least mean distance of their
// points become one, n − 1 times; heights rise.
std::vector<ClusterMerge> AverageLinkage(const Eigen::MatrixXd& distances);
// The points from left to right, so that no branches of the tree cross.
std::vector<int> LeafOrder(const std::vector<ClusterMerge>& tree);

// Classical multidimensional scaling [Torgerson 1952]: points in two dimensions, shape [n, 2],
// whose distances come nearest to those given, about their mean; exact for points of a plane. The
// coordinate of largest magnitude is positive in each column.
Eigen::MatrixXd ScaleToPlane(const Eigen::MatrixXd& distances);

}  // namespace drape
