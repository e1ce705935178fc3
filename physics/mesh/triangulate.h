// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

namespace drape {

// Constrained Delaunay triangulation of the convex hull of points, shape [2, V]. The triangles are
// counter-clockwise and sorted by their vertex indices. `edges` become mesh edges; they must not
// cross.
std::vector<std::array<int, 3>> Triangulate(const Eigen::Matrix2Xd& points,
                                            const std::vector<std::pair<int, int>>& edges);

// Moves the free points, those from `first_free` on, to the area-weighted mean of the centroids of
// the adjacent triangles. Repeated, with a triangulation each time, it makes them even.
void MoveToCentroids(const std::vector<std::array<int, 3>>& triangles, int first_free,
                     Eigen::Matrix2Xd& points);

// An order of the points along a space-filling curve: order[k] = index of the k-th point.
std::vector<int> SpatialOrder(const Eigen::Matrix2Xd& points);

}  // namespace drape
