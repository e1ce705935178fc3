// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "losses/outline/outline.h"
#include "physics/simulation/backend.h"
#include "physics/util/options/field.h"
#include "solver/fit/observation.h"
#include "solver/fit/parametrisation.h"
#include "solver/forward/settle.h"

namespace drape {

struct OutlineResidualOptions {
  SolveMode solve_mode = SolveMode::kStatic;
  // kDynamic only; the staged fit also relaxes its initial guesses by these steps.
  RolloutOptions rollout = {.h = 0.1, .steps = 40};
  // kStatic only. A trial needs more iterations only near a bifurcation.
  EquilibriumOptions equilibrium = {.max_iterations = 30};
  double sigma_px = 0.5;  // standard deviation of r(θ): residual = (r_fit − r_image)/sigma
  // kDynamic: after each accepted step the next rollouts start from the accepted drapes, so that
  // the fit converges to an equilibrium on one branch instead of chasing a transient
  // [METHODS, P22].
  bool warm_restart = true;
  // A trial is rejected without a rollout when the root mean square of the predicted change of its
  // outline is larger [px]. The first evaluation has no prediction.
  double max_outline_change = 4.0;
  // A trial is rejected as another branch when a vertex is further from its linear prediction [m].
  double max_jump = 0.03;
};

template <MutableOrConst<OutlineResidualOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [solve_mode, rollout, equilibrium, sigma_px, warm_restart, max_outline_change, max_jump] =
      options;
  visit(sigma_px, Field{.key = "sigma_px",
                        .doc = "standard deviation of the outline, in pixels of a published image "
                               "(1.39 mm) whatever the image's scale",
                        .unit = "px",
                        .least = 1e-4,
                        .most = 1e4});
  visit(solve_mode,
        Field{.key = "solve", .doc = "fit the equilibrium, or the shape after the settle steps"});
  visit(warm_restart, Field{.key = "warm_restart",
                            .doc = "solve dynamic: trials start from the last accepted drape, not "
                                   "from that of the initial guess"});
  visit(max_outline_change, Field{.key = "max_outline_change",
                                  .doc = "reject a step that is predicted to move the outline "
                                         "further",
                                  .unit = "px",
                                  .least = 0,
                                  .above_least = true});
  visit(max_jump, Field{.key = "max_jump",
                        .doc = "reject a drape with a vertex further from its prediction: it is on "
                               "another branch",
                        .unit = "m",
                        .least = 0,
                        .above_least = true});
  visit(rollout.h, Field{.key = "settle_time_step",
                         .doc = "time step that relaxes an initial guess",
                         .unit = "s",
                         .least = 0,
                         .most = 10,
                         .above_least = true});
  visit(rollout.steps, Field{.key = "settle_steps",
                             .doc = "number of time steps that relax an initial guess",
                             .least = 0,
                             .most = 100000});
  visit(equilibrium.max_iterations,
        Field{.key = "newton_iterations", .least = 1, .is_option = false});
}

// The distance of a drape from the outline of an observation: root mean square over the angles
// [px]. x: [m], shape [3V]. None where the drape has no outline (OutlineFromMesh).
std::optional<double> OutlineRms(const Mesh& mesh, const Eigen::VectorXd& x,
                                 const Observation& observation);

struct RolloutCounts {
  int rollouts = 0;
  int tangents = 0;  // of them, with derivatives
  int failed = 0;    // numerical failures
  int jumps = 0;     // rejected: branch jumps
  int capped = 0;    // rejected before: predicted outlines too far away; not among the rollouts

  RolloutCounts& operator+=(const RolloutCounts& other);
};

// Evaluates the residuals of all observations at one θ: one material, one rollout per observation.
// The rollouts run as one batch before Ceres calls the cost functions. Jacobians use tangents where
// the parametrisation has one table, else adjoints of the K radii (SolveMode::kStatic only).
class OutlineResiduals : public ceres::EvaluationCallback {
 public:
  // Pointers outlive the object. starts: of the drape of each observation; many drapes are stable,
  // and the start says which of them is meant [METHODS, P13].
  OutlineResiduals(Backend* backend, const MaterialParametrisation* parametrisation,
                   const std::vector<Observation>* observations, std::vector<State> starts,
                   const OutlineResidualOptions& options);

  // Continues with another backend of the same model, which outlives the object.
  void Rebind(Backend* backend) { backend_ = backend; }

  // The parameter block that the optimiser changes in place, shape [P].
  double* theta() { return theta_.data(); }
  int num_parameters() const { return static_cast<int>(theta_.size()); }
  int num_observations() const { return static_cast<int>(observations_->size()); }
  int num_angles() const { return static_cast<int>(observations_->front().radius.size()); }
  const MaterialParametrisation& parametrisation() const { return *parametrisation_; }
  const RolloutCounts& counts() const { return counts_; }

  void PrepareForEvaluation(bool with_jacobians, bool new_point) override;

  // Whether all drapes of the last evaluation were found, and on their branches.
  bool all_valid() const;
  // Residuals of observation i, shape [K]. False when its rollout failed or left its branch.
  bool Residuals(int i, double* residuals) const;
  // Their derivatives by `count` parameters from `first` on, row-major, shape [K, count].
  void CopyJacobian(int i, int first, int count, double* jacobian) const;

  // The drape of observation i at the last evaluation, valid or not [m], shape [3V].
  const Eigen::VectorXd& shape(int i) const { return evaluations_[i].x; }

  // A point at which shapes and Jacobians were found.
  struct Point {
    Eigen::VectorXd theta;
    std::vector<Eigen::VectorXd> x;  // by observation [m], shape [3V]
    std::vector<RowMatrix>
        shape_by_theta;        // by observation, where found by tangents, shape [3V, P]
    Eigen::VectorXd residual;  // [observations·K]
    Eigen::MatrixXd jacobian;  // [observations·K, P]
  };
  // The last one; empty before has_accepted().
  bool has_accepted() const { return !accepted_.x.empty(); }
  const Point& accepted() const { return accepted_; }
  // Where the drapes of the next evaluation start.
  const std::vector<State>& starts() const { return starts_; }
  // Makes the drapes of the accepted point the starts.
  void StartFromAccepted();
  // Goes back to an earlier one.
  void Restore(Point point);

 private:
  struct Evaluation {
    bool valid = false;
    Eigen::VectorXd x;     // shape at the end
    RowMatrix x_by_theta;  // its derivative, where computed by tangents
    Eigen::VectorXd residual;
    RowMatrix jacobian;
  };
  bool by_tangents() const { return parametrisation_->has_one_table(); }
  void Evaluate(bool with_jacobians);
  void RunDynamic(const MaterialField& material, bool with_jacobians);
  void RunStatic(const MaterialField& material, bool with_jacobians);
  // Derivatives of drapes at rest, which are given as states.
  void FindTangents(const MaterialField& material, const std::vector<State>& drapes);
  void FindAdjoints(const MaterialField& material, const std::vector<State>& drapes);
  void FillResidual(int i, bool with_jacobian);
  bool ReadOutline(int i, Outline* outline) const;
  bool IsTooFar() const;
  bool LeftBranch(int i) const;
  void PredictShapes();
  void RestartFromLastShapes();
  void Accept();
  bool EvaluatedHere() const;

  Backend* backend_;
  const MaterialParametrisation* parametrisation_;
  const std::vector<Observation>* observations_;
  std::vector<State> starts_;
  OutlineResidualOptions options_;
  Eigen::VectorXd theta_, evaluated_theta_;
  std::vector<Evaluation> evaluations_;
  Point accepted_;
  std::vector<Eigen::VectorXd> predicted_x_;  // shapes at θ, linearised at the accepted point
  RolloutCounts counts_;
};

}  // namespace drape
