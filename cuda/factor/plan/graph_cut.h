// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace drape {

// Undirected, without loops: the neighbours of vertex v are neighbour[start[v]] … start[v + 1] − 1.
struct Graph {
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
Cut MetisCut(const Graph& graph);
// The best of straight cuts through `uv`, shape [2, V].
Cut StraightCut(const Graph& graph, const Eigen::Matrix2Xd& uv);

// Size of the separator, with a fine for unequal sides.
double CutScore(const std::vector<char>& side);

}  // namespace drape
