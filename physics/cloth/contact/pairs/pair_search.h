// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

#include "physics/cloth/contact/pairs/box_tree.h"
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

// The parts of a surface, each in a box.
class BoxedSurface {
 public:
  explicit BoxedSurface(SurfaceParts parts = {}) : parts_(std::move(parts)) {}
  const SurfaceParts& parts() const { return parts_; }
  // Encloses each part while its vertices stay in these boxes, with `more` [m] on all sides.
  void Enclose(const VertexBoxes& boxes, double more, int threads);

  // Boxes of the numbers of parts, and those of edges and triangles in a tree.
  const std::vector<SpaceBox>& vertices() const { return vertices_; }
  const std::vector<SpaceBox>& edges() const { return edges_; }
  const BoxTree& edge_tree() const { return edge_tree_; }
  const BoxTree& triangle_tree() const { return triangle_tree_; }

 private:
  SurfaceParts parts_;
  std::vector<SpaceBox> vertices_, edges_, triangles_;
  BoxTree edge_tree_, triangle_tree_;
};

// All pairs of a cloth whose boxes meet, in the same order with any number of threads. Pairs with a
// common vertex are none.
std::vector<ContactPair> ListPairsWithin(const BoxedSurface& cloth, int threads = 1);
// All such pairs of a part of a cloth and one of an obstacle, which have no vertex in common. Of
// edges, that of the cloth comes first.
std::vector<ContactPair> ListPairsBetween(const BoxedSurface& cloth, const BoxedSurface& obstacle,
                                          int threads = 1);

}  // namespace drape
