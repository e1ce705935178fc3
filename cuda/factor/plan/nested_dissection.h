// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "physics/linalg/blocks/block_matrix.h"

namespace drape {

// Undirected, without loops: the neighbours of vertex v are neighbour[start[v]] … start[v + 1] − 1.
struct VertexGraph {
  std::vector<int> start, neighbour;

  int num_vertices() const { return static_cast<int>(start.size()) - 1; }
};

// No edge joins a vertex of side 0 to one of side 1.
struct Cut {
  static constexpr int kSeparator = 2;

  std::vector<char> side;                                  // [V] 0, 1 or kSeparator
  double score = std::numeric_limits<double>::infinity();  // infinite when a side is empty

  bool found() const { return score < std::numeric_limits<double>::infinity(); }
};

// The best of a few runs of METIS's vertex separator. `graph` is connected.
Cut MetisCut(const VertexGraph& graph);
// The best of straight cuts through `uv`, shape [2, V].
Cut StraightCut(const VertexGraph& graph, const Eigen::Matrix2Xd& uv);

// Size of the separator, with a fine for unequal sides.
double CutScore(const std::vector<char>& side);

// A node of a nested dissection: its vertices separate its children from one another.
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
