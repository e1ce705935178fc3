// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "physics/cloth/contact/contact.h"

namespace drape {

// The gaps of one shape, from which follows that others near it are out of range: a gap changes by
// no more than its vertex moves. Distances from bodies of thousands of triangles are what contact
// costs, and most vertices are far from them.
class Clearance {
 public:
  // Of no shape.
  Clearance() = default;
  // Measures the smallest gap of each vertex of x, shape [3V], with so many threads at a time here
  // and below. The contact outlives the object.
  Clearance(const Contact& contact, const Eigen::VectorXd& x, int threads = 1);

  double gap(int i) const { return gap_[i]; }  // the smallest of vertex i [m]
  // Whether vertex i may be within the range of an obstacle when it is at `place`.
  bool MayTouch(int i, const Eigen::Vector3d& place) const;
  // ShortenMoves of contact.h, to the same result.
  bool ShortenMoves(const Eigen::VectorXd& x, Eigen::VectorXd& dx) const;

 private:
  const Contact* contact_ = nullptr;
  int threads_ = 1;
  Eigen::VectorXd x_, gap_;  // [m]
};

}  // namespace drape
