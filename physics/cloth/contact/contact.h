// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/cloth/contact/obstacles/obstacle.h"

namespace drape {

// Contact of a cloth with obstacles, at its vertices [MODEL, M60], and with itself. The midsurface
// keeps half of the thickness from an obstacle, and its vertices a skin besides; what is left of
// the distance is the gap, which is always positive.
struct Contact {
  double thickness = 4e-4;   // of the cloth [m], ≥ 0
  double skin = 0.0;         // between obstacles and vertices [m], ≥ 0
  double range = 5e-4;       // of the gap in which surfaces push one another [m], > 0
  double stiffness = 100.0;  // κ, of the surfaces' pile [Pa], > 0
  std::vector<Obstacle> obstacles = {};
  bool self = false;  // also contact of the cloth with itself [MODEL, M62]

  // The distance of a vertex from an obstacle, less its gap [m].
  double offset() const { return 0.5 * thickness + skin; }
};

// Contact of one vertex at x that stands for `area` of the cloth [m²].
double ContactEnergy(const Contact& contact, double area, const Eigen::Vector3d& x);          // [J]
Eigen::Vector3d ContactForce(const Contact& contact, double area, const Eigen::Vector3d& x);  // [N]
// The positive semidefinite part of −∂f/∂x, H of a step [N/m].
Eigen::Matrix3d ContactStepStiffness(const Contact& contact, double area, const Eigen::Vector3d& x);
// ∂g/∂x of g(x; w) = h·f(x) − h²·H(x)·w with w held [MODEL, M31].
Eigen::Matrix3d ContactStepDerivative(const Contact& contact, double area, const Eigen::Vector3d& x,
                                      const Eigen::Vector3d& w, double h);

// Contact of all vertices, shape [3V]. threads: number of threads; results do not depend on it.
// The smallest gap [m]; infinite without obstacles.
double SmallestGap(const Contact& contact, const Eigen::VectorXd& x);
// Moves vertices whose gap is less than a tenth of the range away from the obstacle: shapes that
// were interpolated or extrapolated can lie in it. Returns whether it has moved one.
bool PushOut(const Contact& contact, Eigen::VectorXd& x, int threads = 1);
// Moves vertices near the surface of an obstacle as that has moved in the present step, those
// within 5 mm as far, those from 25 mm on not at all.
void FollowObstacles(const Contact& contact, Eigen::VectorXd& x, int threads = 1);
// Shortens the move dx of each vertex at x, whose gaps are positive, so that on the straight way
// no gap falls below a tenth of what it was. Returns whether it has shortened one.
bool ShortenMoves(const Contact& contact, const Eigen::VectorXd& x, Eigen::VectorXd& dx);

// The gaps of one shape, from which follows that others near it are out of range: a gap changes by
// no more than its vertex moves. Distances from bodies of thousands of triangles are what contact
// costs, and most vertices are far from them.
class Clearance {
 public:
  // The clearance of no shape.
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
