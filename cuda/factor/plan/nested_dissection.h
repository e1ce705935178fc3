// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// A node of a nested dissection: its vertices separate those of its children from one another.
struct Separator {
  std::vector<int> vertices;  // in elimination order
  int parent = -1;            // index of a later node; −1 at a root
};

struct DissectionOptions {
  int leaf_vertices = 24;  // parts this small are not dissected further
};

// Nested dissection of the graph of `pattern` [George 1973]: children before parents. Each cut is
// the best of METIS's vertex separators and of straight cuts through `uv` (shape [2, V]), whose
// separators are minimal vertex covers of the cut edges (König).
std::vector<Separator> NestedDissection(const BlockPattern& pattern, const Eigen::Matrix2Xd& uv,
                                        const DissectionOptions& options);

// The fundamental supernodes of an order of the vertices that is a postorder of its elimination
// tree [Liu 1992]: chains of vertices whose columns of L reach the same later ones.
std::vector<Separator> MakeSeparators(const BlockPattern& pattern, const std::vector<int>& order);

}  // namespace drape
