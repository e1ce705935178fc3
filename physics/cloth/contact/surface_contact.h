// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/friction.h"
#include "physics/cloth/contact/pairs/candidates.h"
#include "physics/cloth/contact/pairs/contact_pair.h"
#include "physics/mesh/mesh.h"

namespace drape {

// A place where a cloth touches itself or the mesh of an obstacle, in one shape. The numbers of the
// vertices of obstacles come after those of the cloth.
struct SurfaceTouch {
  ContactPair pair;
  PairDistance distance;
  double area;  // it stands for [m²]
  Mollifier mollifier;
};

// Contact of a cloth with itself [MODEL, M62] and with triangle meshes [MODEL, M63]: pairs of a
// vertex and a face, and of two edges, push one another apart by the barrier of contact.h while
// their distance is less than thickness and range together; of an obstacle, half of the thickness.
// Pairs that are as near at rest, as in slivers, do not push, but do not cross either; nor does a
// vertex of the cloth and a face of an obstacle, which push by their distance alone [MODEL, M60].
class SurfaceContact {
 public:
  // self: of the cloth with itself, without its obstacles; none: there is no such contact.
  // vertex_area: shape [V] [m²]. The mesh is not kept.
  SurfaceContact(const Mesh& mesh, Eigen::VectorXd vertex_area, const std::optional<Contact>& self);

  // That work at the same time, with the same result; one at first.
  void UseThreads(int threads) {
    threads_ = threads;
    candidates_.UseThreads(threads);
  }
  // The meshes among the obstacles of `around` are those of the present step, at its end.
  void SetObstacles(const Contact& around);
  bool HasObstacles() const { return obstacle_x_.size() > 0; }
  // Whether no pair crosses or comes nearer than a tenth of its gap while the cloth goes straight
  // from x, where it is at the begin of the step, by dx and the obstacles move as they do in it.
  bool CanFollow(const Eigen::VectorXd& x, const Eigen::VectorXd& dx);
  // Changes dx to moves for which the way is free, in parts of the step [MODEL, M63]. Where it
  // finds none it returns a vertex of the cloth that stays in the way.
  std::optional<int> GiveWay(const Eigen::VectorXd& x, Eigen::VectorXd& dx);

  // Shortens the moves dx of single vertices at x so that on the straight way no pair crosses or
  // comes nearer than a tenth of its gap, while obstacles rest at the end of their step. Returns
  // whether it has shortened one.
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
  // All pairs that push, ascending. They are kept for one shape, which another replaces.
  const std::vector<SurfaceTouch>& ListTouches(const Eigen::VectorXd& x) const;
  // By which a pair pushes its parts apart [N].
  double NormalForce(const SurfaceTouch& touch) const;
  bool IsOfObstacle(const ContactPair& pair) const;
  // What rubs there, without its limit. before: at the begin of the step.
  Rub RubAt(const SurfaceTouch& touch, const Eigen::VectorXd& before) const;
  // The vertices of the pairs of the cloth that push, and of those that may do so soon.
  std::vector<std::array<int, 4>> ListNear(const Eigen::VectorXd& x) const;
  // The smallest gap of the pairs that push [m]; the range if none does.
  double SmallestGap(const Eigen::VectorXd& x) const;

 private:
  // What a pair keeps between its parts.
  struct Layer {
    double thickness, range;  // [m]
    double stiffness;         // [Pa]
    double reach() const { return thickness + range; }
  };
  const Layer& LayerBetween(const ContactPair& pair) const {
    return IsOfObstacle(pair) ? obstacle_layer_ : self_layer_;
  }
  double Gap(const SurfaceTouch& touch) const {
    return touch.distance.value - LayerBetween(touch.pair).thickness;
  }
  Eigen::Index CoordinatesOfCloth() const { return rest_x_.size(); }
  bool IsOfCloth(int vertex) const { return 3 * vertex < CoordinatesOfCloth(); }
  // The shape of cloth and obstacles at the end of the step, and the moves of both where these
  // rest.
  Eigen::VectorXd WithObstacles(const Eigen::VectorXd& x) const;
  Eigen::VectorXd WithResting(const Eigen::VectorXd& dx) const;
  PairColumns Gather(const ContactPair& pair, const Eigen::VectorXd& x) const;
  int FirstOfCloth(const ContactPair& pair) const;
  bool IsSafe(const ContactPair& pair, const Eigen::VectorXd& x, const Eigen::VectorXd& dx) const;
  void PushApart(const ContactPair& pair, const Eigen::VectorXd& x, Eigen::VectorXd& dx) const;
  bool Pushes(const ContactPair& pair) const;
  double RestSquares(const ContactPair& pair) const;
  PairMatrix Curvature(const SurfaceTouch& touch, const Eigen::VectorXd& x) const;
  double Area(const ContactPair& pair) const;
  const RestEdge& EdgeBetween(int a, int b) const;

  Layer self_layer_, obstacle_layer_ = {};
  Eigen::VectorXd rest_x_, vertex_area_;
  std::vector<RestEdge> edges_;  // ascending by their vertices
  PairCandidates candidates_;
  int threads_ = 1;
  mutable Eigen::VectorXd touched_x_;  // that of touches_; empty: none
  mutable std::vector<SurfaceTouch> touches_;
  // Of the obstacles, at the end of the step and at its begin, shape [3B].
  Eigen::VectorXd obstacle_x_, obstacle_before_;
  std::vector<std::array<int, 3>> obstacle_triangles_;
};

}  // namespace drape
