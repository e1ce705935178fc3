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

// A surface: vertices of these numbers, edges of two of them and triangles of three.
struct SurfaceParts {
  std::vector<int> vertices = {};
  std::vector<std::array<int, 2>> edges = {};
  std::vector<std::array<int, 3>> triangles = {};
};

// All pairs of a cloth that can come nearer than `reach` [m] while each vertex stays in its box,
// and others, ascending. Pairs with a common vertex are none.
std::vector<ContactPair> ListPairsWithin(const SurfaceParts& cloth, const VertexBoxes& boxes,
                                         double reach);
// All such pairs of a part of a cloth and one of an obstacle, which have no vertex in common. Of
// edges, that of the cloth comes first.
std::vector<ContactPair> ListPairsBetween(const SurfaceParts& cloth, const SurfaceParts& obstacle,
                                          const VertexBoxes& boxes, double reach);

}  // namespace drape
