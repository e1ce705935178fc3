// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "physics/cloth/contact/pairs/contact_pair.h"

namespace drape {

// An axis-parallel box around the places that each vertex may take, shape [3, V] each [m].
struct VertexBoxes {
  Eigen::Matrix3Xd low, high;
};

// All pairs of a cloth that can come nearer than `reach` [m] while each vertex stays in its box,
// and others, ascending. Pairs with a common vertex are none.
// edges: two vertices each; triangles: three.
std::vector<ContactPair> ListPairsWithin(const std::vector<std::array<int, 2>>& edges,
                                         const std::vector<std::array<int, 3>>& triangles,
                                         const VertexBoxes& boxes, double reach);

}  // namespace drape
