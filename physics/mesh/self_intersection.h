// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

#include "physics/mesh/mesh.h"

namespace drape {

// Pairs of triangles that meet where they should not, at most `most` of them, ascending: two
// triangles without a common vertex that touch or cross, two that share a vertex or an edge and
// have another point in common, and a triangle without area, paired with itself. Decided by exact
// predicates, so that the answer does not depend on a tolerance.
// triangles: indices of vertices; x: finite positions [m], shape [3V]. Both are CHECKed.
// Measured: 10 ms for 7,000 triangles without an intersection.
std::vector<std::pair<int, int>> FindSelfIntersections(
    const std::vector<std::array<int, 3>>& triangles, const Eigen::VectorXd& x, int most = 1);

// How many pairs of faces of a cloth meet at x, shape [3V], counted up to 1,000.
int CountSelfIntersections(const Mesh& mesh, const Eigen::VectorXd& x);

}  // namespace drape
