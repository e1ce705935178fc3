// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "physics/cloth/assembly/step_solver.h"
#include "physics/cloth/contact/contact.h"
#include "physics/cloth/contact/friction.h"
#include "physics/cloth/contact/surface_contact.h"
#include "physics/cloth/state.h"
#include "physics/simulation/statics/stiffness.h"

namespace drape {

struct ImplicitEulerOptions {
  double tolerance = 1e-8;   // ‖f − M(x − y)/h²‖ ≤ tolerance × weight
  int max_iterations = 200;  // Newton steps
  int max_halvings = 40;     // of one Newton step, which contact can be near to
  // Coulomb's friction, smoothed and lagged [MODEL, M61].
  double friction = 0.0;          // μ with obstacles
  double self_friction = 0.0;     // μ of the cloth with itself
  double creep_speed = 1e-3;      // relative speed above which a contact slides [m/s], > 0
  int friction_rounds = 5;        // solves of a step for the lagged normal forces
  double friction_change = 0.01;  // of these forces, below which no further round follows
  // Contact of the cloth with itself [MODEL, M62]; obstacles are those of the scene or the step,
  // whose meshes also meet faces and edges of the cloth [MODEL, M63].
  std::optional<Contact> self_contact = {};
  int threads = 1;  // of a step, whose result does not depend on them
  // For the pattern of the model, of which copies are used; none: MakeLinearSolver's.
  std::shared_ptr<const LinearSolver> linear_solver = {};
  const std::atomic<bool>* cancel = nullptr;  // ends a step early when it turns true
  // Sees each shape x, shape [3V], that a step has gone to.
  std::function<void(const Eigen::VectorXd& x)> on_accept = {};
};

// How a step of an integrator has ended.
enum class IntegratorStatus {
  kOk,
  kNotPositiveDefinite,  // a factorisation failed, with every shift allowed
  kNotConverged,         // the budget of Newton's or of conjugate gradients' iterations is spent
  kPinched,              // an obstacle moves into cloth that other cloth keeps in its place
  kNotFinite,            // positions or velocities overflowed
  kCancelled
};

// A vertex that a spring holds at a place that can change in time, beside the handles of the scene.
struct Pin {
  int vertex = 0;
  double stiffness = 1e3;  // [N/m]
  Eigen::Vector3d place;   // [m]
};

// What is around a cloth at the end of a step, beside its scene.
struct Surroundings {
  const Contact* contact = nullptr;  // instead of the scene's
  std::vector<Pin> pins = {};
};

// What the last step took.
struct ImplicitEulerCost {
  int newton_steps = 0, friction_rounds = 0;
  int analyses = 0;  // of the pattern of a matrix that new pairs in contact have widened
};

// Where a step has failed: the vertex with the largest unbalanced force, or the first whose force
// is not finite, at the last shape that was accepted; pinched: one that is in the way.
struct ImplicitEulerFailure {
  int vertex = -1;                                  // none: the last step has not failed
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // [m]
};

// Implicit Euler to convergence [MODEL, M32]: M·(x − y)/h² = f(x), y = x_t0 + h·v_t0, by Newton's
// method on the exact K, symmetrised and shifted where M/h² + K is not positive definite, with
// backtracking on the energy. No vertex enters an obstacle, no part of the cloth a triangle mesh
// and, with self-contact, no part of the cloth another, if that is so at the start.
class ImplicitEuler {
 public:
  ImplicitEuler(std::shared_ptr<const ClothModel> model, const MaterialField& material, double h,
                const ImplicitEulerOptions& options);

  // One step. A vertex that the motion of an obstacle has swallowed is first pushed out of it
  // (PushOut). After another status than kOk the state is not to be used.
  [[nodiscard]] IntegratorStatus Advance(State& state, const Surroundings& around = {});
  const ImplicitEulerCost& cost() const { return cost_; }
  const ImplicitEulerFailure& failure() const { return failure_; }

 private:
  // A shape tried for the end of a step.
  struct Trial {
    Eigen::VectorXd x;                    // [m]
    Eigen::VectorXd elastic, unbalanced;  // with gravity; f − M(x − y)/h² [N]
    double residual = 0.0;                // norm of `unbalanced` by the weight
    double potential = 0.0;               // ½‖x − y‖²_M/h², of contact and friction [J]
  };
  // The last step of Newton's method.
  struct LastStep {
    bool whole = false;  // not shortened
    bool slow = false;   // whole, but more than half of the residual is left
    int failures = 0;    // of M/h² + K to be positive definite, one after the other
    int waits = 0;       // steps until it is tried again
  };
  // The matrix and its factor, on a pattern that contact can widen.
  struct Linear {
    Linear(std::shared_ptr<const ClothModel> model, const MaterialField& material,
           std::unique_ptr<LinearSolver> linear, int threads)
        : solver(std::move(model), std::move(linear)), stiffness(solver, material) {
      solver.SetThreads(threads);
    }
    StepSolver solver;
    Stiffness stiffness;
  };

  const Contact* contact() const;  // of the surroundings, or the scene's
  bool Cancelled() const { return options_.cancel != nullptr && *options_.cancel; }
  void SetObstacles();
  IntegratorStatus Pinched(int vertex, const Eigen::VectorXd& x);
  IntegratorStatus Start(const Eigen::VectorXd& from, Eigen::VectorXd& start);
  Trial At(const Eigen::VectorXd& x);
  void AddSurroundings(Trial& trial);
  void AddContact(Trial& trial) const;
  void Assemble(const Eigen::VectorXd& x, StiffnessPart part);
  void AddBlocks(const Eigen::VectorXd& x, StiffnessPart part);
  bool HasBlocksOfPairs(const Eigen::VectorXd& x);
  void Widen(const Eigen::VectorXd& x);
  bool Factor(const Eigen::VectorXd& x, LastStep* last);
  bool Backtrack(const Eigen::VectorXd& dx, Trial& here, LastStep* last);
  IntegratorStatus Minimise(double enough, Trial& here);
  RubForce Rubbing(const Rub& rub, const Eigen::VectorXd& x) const;
  // Finds the normal forces at x. Returns by how much of their sum they have changed.
  double FindRubs(const Eigen::VectorXd& before, const Eigen::VectorXd& x);
  void KeepShares(const std::vector<Rub>& known);
  void AddObstacleRubs(const Eigen::VectorXd& before, const Eigen::VectorXd& x);
  void AddSurfaceRubs(const Eigen::VectorXd& before, const Eigen::VectorXd& x);

  std::shared_ptr<const ClothModel> model_;
  MaterialField material_;
  double h_;
  ImplicitEulerOptions options_;
  std::unique_ptr<Linear> linear_;
  std::optional<SurfaceContact> surfaces_;  // with itself and with meshes, where there are any
  Eigen::VectorXd mass_by_h2_;
  double weight_;
  Eigen::VectorXd coasted_;  // y of the present step
  Surroundings around_;      // of the present step
  Clearance clearance_;      // at its begin
  std::vector<Rub> rubs_;
  ImplicitEulerCost cost_;
  ImplicitEulerFailure failure_;
};

}  // namespace drape
