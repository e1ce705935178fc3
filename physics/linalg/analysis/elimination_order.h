// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// The order in which a factorisation eliminates the vertices of a pattern, a postorder of its
// elimination tree [Liu 1992].
struct EliminationOrder {
  std::vector<int> vertex;  // [V] the k-th
  // Operations of a factorisation of as many scalars, 1/27 of the real one: in this order, and in
  // the order of the last dissection.
  double operations = 0.0, dissected_operations = 0.0;
};

// Nested dissection by METIS [George 1973].
EliminationOrder DissectVertices(const BlockPattern& pattern);

// An order for another pattern of the same vertices. Two that a new block joins across a separator
// would make its two sides one: of them, as few as a greedy cover finds move into it, in a fraction
// of the time of a dissection. Where a factorisation would then take a quarter more operations than
// after the last dissection there is a new one.
EliminationOrder AdaptOrder(const EliminationOrder& order, const BlockPattern& pattern,
                            const BlockPattern& other);

// The place of each vertex in an order.
std::vector<int> FindPlaces(const std::vector<int>& order);

// The elimination tree: the parent of each place in the order, V of a root.
std::vector<int> EliminationTree(const BlockPattern& pattern, const std::vector<int>& order);

}  // namespace drape
