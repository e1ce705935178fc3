// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <compare>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "physics/cloth/contact/pairs/contact_pair.h"

namespace drape {

using SpaceBox = Eigen::AlignedBox3d;  // bounds included [m]

// A tree of boxes with eight children a node, which finds those that meet another. It has them in
// single precision, rounded outwards, so that it can also find one that is almost met. Boxes that
// move are enclosed again without another order, so that it stays good while neighbours stay
// neighbours.
class BoxTree {
 public:
  // Replaces the boxes. If there are as many as before, they keep their order.
  void Enclose(const std::vector<SpaceBox>& boxes);

  // Calls visit(k) for the number of each box that meets this one, in no particular order.
  template <class Visit>
  void ForEachMeeting(const SpaceBox& box, const Visit& visit) const {
    if (!order_.empty()) Descend(Rounded(box), -1, visit);
  }
  // Calls visit(k) for the number of each box that meets the one at `place` of the order and comes
  // after it there, so that each pair of boxes that meet is visited once.
  template <class Visit>
  void ForEachLaterMeeting(int place, const Visit& visit) const {
    Descend(BoxAt(place), place, visit);
  }
  // The numbers of the boxes in the order of the tree, where neighbours are near one another.
  const std::vector<int>& order() const { return order_; }

 private:
  static constexpr int kChildren = 8, kMostLevels = 11;
  using Floats = float __attribute__((vector_size(4 * kChildren)));
  using Flags = std::int32_t __attribute__((vector_size(4 * kChildren)));
  using Bytes = std::int8_t __attribute__((vector_size(kChildren)));
  using RoundedBox = Eigen::AlignedBox3f;
  // The boxes of the children, or of the leaves below the lowest nodes; none: low above high.
  struct Node {
    std::array<Floats, 3> low, high;
  };

  static RoundedBox Rounded(const SpaceBox& box);
  // A byte for each child, 0 of those that do not meet the box.
  static std::uint64_t Meeting(const Node& node, const RoundedBox& box) {
    Flags meets = node.low[0] <= box.max()[0];
    meets &= node.high[0] >= box.min()[0];
    for (int k = 1; k < 3; ++k) {
      meets &= node.low[k] <= box.max()[k];
      meets &= node.high[k] >= box.min()[k];
    }
    const Bytes bytes = __builtin_convertvector(meets, Bytes);
    std::uint64_t all;
    std::memcpy(&all, &bytes, sizeof all);
    return all;
  }

  // Visits the leaves after the place `after`.
  template <class Visit>
  void Descend(const RoundedBox& box, int after, const Visit& visit) const {
    struct Open {
      int level, node;
    };
    std::array<Open, kMostLevels * kChildren> open;
    int count = 0;
    open[count++] = {static_cast<int>(level_start_.size()) - 1, 0};
    while (count > 0) {
      const auto [level, node] = open[--count];
      std::uint64_t meeting = Meeting(node_[level_start_[level] + node], box);
      while (meeting != 0) {
        const int child = std::countr_zero(meeting) / 8;
        meeting &= ~(std::uint64_t{0xff} << (8 * child));
        const int below = kChildren * node + child;
        if (level == 0) {
          if (below > after) visit(order_[below]);
        } else if (std::int64_t{below + 1} << (3 * level) > after) {
          open[count++] = {level - 1, below};
        }
      }
    }
  }

  // The box of child `place` % 8 of node `place` / 8: the leaf at that place of the order, if the
  // node is one of the lowest.
  RoundedBox BoxAt(int place) const;
  void Sort(const std::vector<SpaceBox>& boxes, int begin, int end);
  void Put(int level, int place, const RoundedBox& box);

  std::vector<int> order_;        // the numbers of the boxes
  std::vector<Node> node_;        // level by level from the leaves on
  std::vector<int> level_start_;  // [levels] in node_
};

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
struct BoxedSurface {
  SurfaceParts parts = {};
  // Boxes by the number of the part; edges and triangles are in trees as well.
  std::vector<SpaceBox> vertices = {}, edges = {}, triangles = {};
  BoxTree edge_tree = {}, triangle_tree = {};

  // Encloses each part while its vertices stay in these boxes, with `more` [m] on all sides.
  void Enclose(const VertexBoxes& boxes, double more, int threads);
};

// The pairs of a cloth, and of a cloth and obstacles, that can be near one another in shapes near a
// reference shape. Only what is near is looked at again while the cloth moves little. A shape has
// the vertices of the cloth and then the vertices of the obstacles.
class PairCandidates {
 public:
  struct Candidate {
    double distance;  // in the reference shape [m]
    ContactPair pair;
    std::partial_ordering operator<=>(const Candidate&) const = default;
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
