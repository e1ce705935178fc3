// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/pairs/candidates.h"
#include "physics/cloth/contact/pairs/contact_pair.h"
#include "physics/mesh/mesh.h"

namespace drape {

// A place where a cloth touches itself, in one shape.
struct SurfaceTouch {
  ContactPair pair;
  PairDistance distance;
  double area;  // it stands for [m²]
  Mollifier mollifier;
};

// Contact of a cloth with itself [MODEL, M62]: pairs of a vertex and a face, and of two edges, push
// one another apart by the barrier of contact.h while their distance is less than thickness and
// range together. Pairs that are as near at rest, as in slivers, do not push, but do not cross
// either.
class SurfaceContact {
 public:
  // surface: its obstacles are not read. vertex_area: shape [V] [m²]. The mesh is not kept.
  SurfaceContact(const Mesh& mesh, Eigen::VectorXd vertex_area, const Contact& surface);

  // Shortens the moves dx of single vertices at x so that on the straight way no pair crosses or
  // comes nearer than a tenth of its gap. Returns whether it has shortened one.
  bool ShortenMoves(const Eigen::VectorXd& x, Eigen::VectorXd& dx);
  // Finds the pairs that are near at x.
  void Know(const Eigen::VectorXd& x);

  // Adds the forces [N] to f, shape [3V]. Returns the energy [J]. Here and below x is a shape on
  // the way of the last ShortenMoves, or that of the last Know.
  double AddForces(const Eigen::VectorXd& x, Eigen::VectorXd& f) const;
  // Calls add(i, j, block) for the blocks i ≤ j of −∂f/∂x [N/m], or of the sum of the positive or
  // negative semidefinite parts of all pairs.
  enum class StiffnessPart { kWhole, kPositive, kNegative };
  using BlockVisitor = std::function<void(int i, int j, const Eigen::Matrix3d& block)>;
  void ForEachStiffness(const Eigen::VectorXd& x, StiffnessPart part,
                        const BlockVisitor& add) const;
  // All pairs that push, ascending.
  std::vector<SurfaceTouch> ListTouches(const Eigen::VectorXd& x) const;
  // By which a pair pushes its parts apart [N].
  double NormalForce(const SurfaceTouch& touch) const;
  // The vertices of the pairs that push, and of those that may do so soon.
  std::vector<std::array<int, 4>> ListNear(const Eigen::VectorXd& x) const;
  // The smallest gap of the pairs that push [m]; the range if none does.
  double SmallestGap(const Eigen::VectorXd& x) const;

 private:
  double Gap(const SurfaceTouch& touch) const { return touch.distance.value - surface_.thickness; }
  double Reach() const { return surface_.thickness + surface_.range; }
  bool Pushes(const ContactPair& pair) const;
  double RestSquares(const ContactPair& pair) const;
  PairMatrix Curvature(const SurfaceTouch& touch, const Eigen::VectorXd& x) const;
  double Area(const ContactPair& pair) const;
  const RestEdge& EdgeBetween(int a, int b) const;

  Contact surface_;
  Eigen::VectorXd rest_x_, vertex_area_;
  std::vector<RestEdge> edges_;  // ascending by their vertices
  PairCandidates candidates_;
};

}  // namespace drape
