// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/friction.h"
#include "physics/cloth/contact/pairs/candidates.h"
#include "physics/cloth/contact/pairs/contact_pair.h"
#include "physics/mesh/mesh.h"

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
// Calls add(i, j, block) for the blocks i ≤ j of −∂f/∂x [N/m], or of the sum of the positive
// semidefinite parts of all pairs.
enum class StiffnessPart { kWhole, kPositive };
using BlockVisitor = std::function<void(int i, int j, const Eigen::Matrix3d& block)>;
void ForEachPairStiffness(const ActivePairs& pairs, StiffnessPart part, const BlockVisitor& add);
// The force that pushes the parts of a pair apart [N].
double NormalForce(const ActivePair& pair);
// The friction contact of a pair; its force limit is not set. before: positions of the cloth at the
// start of the step.
Rub MakeRub(const ActivePair& pair, const Eigen::VectorXd& before);

// The search for pairs in contact: a cloth with itself [MODEL, M62] and with triangle meshes
// [MODEL, M63]. Pairs of a vertex and a face, and of two edges, push one another apart
// (ActivePair) while their distance is less than thickness and range together; from an
// obstacle, half of the thickness counts. Pairs that are as near at rest, as in slivers, do not
// push, but do not cross either (FindFreeStep); nor does a vertex of the cloth and a face of an
// obstacle, which push by their distance alone [MODEL, M60].
class SurfaceContact {
 public:
  // self: contact of the cloth with itself, without its obstacles; none: there is no such contact.
  // vertex_area: shape [V] [m²]. The mesh is not kept.
  SurfaceContact(const Mesh& mesh, Eigen::VectorXd vertex_area, const std::optional<Contact>& self);

  // Number of threads (default 1). The result does not depend on it.
  void UseThreads(int threads) {
    threads_ = threads;
    candidates_.UseThreads(threads);
  }
  int threads() const { return threads_; }
  // Takes the meshes among the obstacles of `around`, as they are in the present step.
  void SetObstacles(const Contact& around);
  bool HasObstacles() const { return obstacle_x_.size() > 0; }
  // Positions of the vertices of obstacles at the end of the step and at its start, shape [3B].
  const Eigen::VectorXd& obstacle_x() const { return obstacle_x_; }
  const Eigen::VectorXd& obstacle_before() const { return obstacle_before_; }

  // Returns the active pairs at x. They are kept until another shape or other obstacles replace
  // them.
  const ActivePairs& FindActivePairs(const Eigen::VectorXd& x);
  // Returns the pairs that can come near one another on the straight way from x to x + dx, shapes
  // of cloth and obstacles, nearest first.
  std::span<const PairCandidates::Candidate> FindCandidates(const Eigen::VectorXd& x,
                                                            const Eigen::VectorXd& dx);
  // The vertices of the pairs of the cloth that push, and of pairs that may do so soon.
  std::vector<std::array<int, 4>> ListNear(const Eigen::VectorXd& x);
  // The smallest gap of the pairs that push [m]; the range if none does.
  double SmallestGap(const Eigen::VectorXd& x);

  bool IsOfCloth(int vertex) const { return 3 * vertex < rest_x_.size(); }
  bool IsOfObstacle(const ContactPair& pair) const;
  const ContactLayer& LayerBetween(const ContactPair& pair) const {
    return IsOfObstacle(pair) ? obstacle_layer_ : self_layer_;
  }

 private:
  void Cover(const Eigen::VectorXd& x);
  Eigen::VectorXd WithObstacles(const Eigen::VectorXd& x) const;
  PairColumns Gather(const ContactPair& pair, const Eigen::VectorXd& x) const;
  ActivePair Activate(const ContactPair& pair, const PairDistance& distance,
                      const Eigen::VectorXd& x) const;
  bool Pushes(const ContactPair& pair) const;
  double RestSquares(const ContactPair& pair) const;
  double Area(const ContactPair& pair) const;
  const RestEdge& EdgeBetween(int a, int b) const;

  ContactLayer self_layer_, obstacle_layer_;
  Eigen::VectorXd rest_x_, vertex_area_;
  std::vector<RestEdge> edges_;  // ascending by their vertices
  PairCandidates candidates_;
  int threads_ = 1;
  Eigen::VectorXd active_x_;  // where active_ was found; empty: nowhere
  ActivePairs active_;
  Eigen::VectorXd obstacle_x_, obstacle_before_;
  std::vector<std::array<int, 3>> obstacle_triangles_;
};

// Steps that no pair of surfaces crosses on the straight way, by continuous collision detection.
// A step is free if no pair comes nearer than a tenth of its gap.

// Returns whether the step dx of the cloth from x is free while obstacles move from the start of
// their step to its end.
bool IsStepFree(SurfaceContact& surfaces, const Eigen::VectorXd& x, const Eigen::VectorXd& dx);
// Changes dx to a step that is free while obstacles move, in parts of the step [MODEL, M63].
// Returns a vertex of the cloth that stays in the way if there is none.
std::optional<int> FindFreeStep(SurfaceContact& surfaces, const Eigen::VectorXd& x,
                                Eigen::VectorXd& dx);
// Shortens the moves dx of single vertices at x to a free step, with obstacles at the end of their
// step. Returns whether it has shortened one.
bool LimitStep(SurfaceContact& surfaces, const Eigen::VectorXd& x, Eigen::VectorXd& dx);

}  // namespace drape
