// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "physics/cloth/contact/active_pairs.h"
#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/pairs/candidates.h"
#include "physics/cloth/contact/pairs/contact_pair.h"
#include "physics/mesh/mesh.h"

namespace drape {

// The search for pairs in contact: a cloth with itself [MODEL, M62] and with triangle meshes
// [MODEL, M63]. Pairs of a vertex and a face, and of two edges, push one another apart
// (active_pairs.h) while their distance is less than thickness and range together; from an
// obstacle, half of the thickness counts. Pairs that are as near at rest, as in slivers, do not
// push, but do not cross either (step_limit.h); nor does a vertex of the cloth and a face of an
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

}  // namespace drape
