// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "physics/cloth/contact/pairs/contact_pair.h"
#include "physics/cloth/contact/pairs/pair_search.h"

namespace drape {

// The pairs of a cloth, and of a cloth and obstacles, that can be near one another in shapes near a
// reference shape. Only what is near is looked at again while the cloth moves little. A shape has
// the vertices of the cloth and then those of the obstacles.
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
  // That search at the same time, with the same result; one at first.
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
  // Those that can come within reach by the ways of their vertices, shape [V] [m].
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

// The longest move of a vertex [m].
double LongestMove(const Eigen::VectorXd& dx);

}  // namespace drape
