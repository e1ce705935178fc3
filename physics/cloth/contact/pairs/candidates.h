// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <tuple>
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

  // Boxes by the number of the part; edges and triangles are in trees as well.
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
// edges, the cloth's edge comes first.
std::vector<ContactPair> ListPairsBetween(const BoxedSurface& cloth, const BoxedSurface& obstacle,
                                          int threads = 1);

// The pairs of a cloth, and of a cloth and obstacles, that can be near one another in shapes near a
// reference shape. Only what is near is looked at again while the cloth moves little. A shape has
// the vertices of the cloth and then the vertices of the obstacles.
class PairCandidates {
 public:
  struct Candidate {
    double distance;  // in the reference shape [m]
    ContactPair pair;
    friend bool operator<(const Candidate& a, const Candidate& b) {
      return std::tie(a.distance, a.pair) < std::tie(b.distance, b.pair);
    }
  };

  // reach: distances [m] above which a pair is not wanted. of_cloth: whether two parts of the cloth
  // are a pair.
  PairCandidates(SurfaceParts cloth, double reach, bool of_cloth = true);
  // Number of threads (default 1). The result does not depend on it.
  void UseThreads(int threads) { threads_ = threads; }
  // Other obstacles from now on, none if it has no parts. All shapes are unknown.
  void SetObstacles(SurfaceParts obstacles, double reach);

  // Makes all shapes known in which each vertex is on the straight way from x to x + dx. x becomes
  // the reference shape where it is not near enough to the present one.
  void Cover(const Eigen::VectorXd& x, const Eigen::VectorXd& dx);
  // Whether the vertices of x are where Cover has made shapes known.
  bool Covers(const Eigen::VectorXd& x) const;
  // All pairs that may be within reach in shapes whose vertices are at most `move` [m] off x, which
  // has to be covered, and other pairs; nearest first in the reference shape.
  std::span<const Candidate> Near(const Eigen::VectorXd& x, double move) const;

 private:
  // Adds the pairs that can come within reach by the moves of their vertices, shape [V] [m].
  void AddCandidates(const std::vector<ContactPair>& pairs, const Eigen::VectorXd& x,
                     const Eigen::VectorXd& ways);

  BoxedSurface cloth_, obstacles_;
  double reach_;
  bool of_cloth_;
  int threads_ = 1;
  VertexBoxes known_;
  Eigen::VectorXd reference_;
  std::vector<Candidate> candidates_;  // ascending
};

// a and b one after the other.
Eigen::VectorXd Joined(const Eigen::VectorXd& a, const Eigen::VectorXd& b);
// The longest move of a vertex [m].
double LongestMove(const Eigen::VectorXd& dx);

}  // namespace drape
