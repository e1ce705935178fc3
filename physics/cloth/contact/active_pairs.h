// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "physics/cloth/contact/friction.h"
#include "physics/cloth/contact/pairs/contact_pair.h"

namespace drape {

// What two surfaces keep between them.
struct ContactLayer {
  double thickness = 0.0, range = 0.0;  // [m]
  double stiffness = 0.0;               // [Pa]
  double reach() const { return thickness + range; }
};

// A pair of a vertex and a face, or of two edges, that is in contact in one shape: a cloth touches
// itself [MODEL, M62] or the mesh of an obstacle [MODEL, M63]. The vertices of obstacles are
// numbered after the vertices of the cloth.
struct ActivePair {
  ContactPair pair;
  PairColumns places;  // of its vertices [m]
  PairDistance distance;
  double area;  // it stands for [m²]
  Mollifier mollifier;
  double rest_squares;  // of the lengths of two edges at rest, multiplied [m⁴]
  ContactLayer layer;
  std::array<bool, 4> of_cloth;   // each vertex
  Eigen::Vector3d obstacle_move;  // of the obstacle's point in this step [m]

  bool of_obstacle() const { return !of_cloth[0] || !of_cloth[3]; }
  double gap() const { return distance.value - layer.thickness; }
};
using ActivePairs = std::vector<ActivePair>;  // ascending

// The barrier potential of contact.h between the parts of each pair [MODEL, M62].

// Adds the forces [N] to f, shape [3V]. Returns the energy [J].
double AddPairForces(const ActivePairs& pairs, Eigen::VectorXd& f);
// Calls add(i, j, block) for the blocks i ≤ j of −∂f/∂x [N/m], or of the sum of the positive or
// negative semidefinite parts of all pairs.
enum class StiffnessPart { kWhole, kPositive, kNegative };
using BlockVisitor = std::function<void(int i, int j, const Eigen::Matrix3d& block)>;
void ForEachPairStiffness(const ActivePairs& pairs, StiffnessPart part, const BlockVisitor& add);
// The force that pushes the parts of a pair apart [N].
double NormalForce(const ActivePair& pair);
// The friction contact of a pair; its force limit is not set. before: positions of the cloth at the
// start of the step.
Rub MakeRub(const ActivePair& pair, const Eigen::VectorXd& before);

}  // namespace drape
