// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/evaluation_callback.h>

#include <Eigen/Core>
#include <limits>
#include <span>
#include <vector>

#include "losses/outline/outline.h"
#include "physics/simulation/backend.h"
#include "solver/fit/observation.h"
#include "solver/fit/parameters/parametrisation.h"
#include "solver/forward/solve_mode.h"

namespace drape {

struct OutlineResidualOptions {
  SolveMode integrator = SolveMode::kStatic;
  RolloutOptions rollout;          // dynamic only
  EquilibriumOptions equilibrium;  // static only
  double sigma_px = 1.0;  // standard deviation of r(θ): residual = (r_fit − r_image)/sigma
  // After each accepted step the next rollouts start from the accepted drapes, so that the fit
  // converges to an equilibrium on one branch instead of chasing a transient [METHODS, P22].
  bool warm_restart = true;
  // A trial whose predicted outline differs by more than this (root mean square) is refused without
  // a rollout: so far the prediction is none [px].
  double max_outline_change = std::numeric_limits<double>::infinity();
  double max_jump = 3e-3;  // a trial shape further than this from its linear prediction is another
                           // branch and is refused [m]
};

struct RolloutCounts {
  int rollouts = 0;
  int tangents = 0;  // of them, with derivatives
  int failed = 0;    // numerical failures
  int jumps = 0;     // refused: branch jumps
  int capped = 0;    // refused before: predicted outlines too far away; not among the rollouts

  RolloutCounts& operator+=(const RolloutCounts& other);
};

// All rollouts of one evaluation of the optimiser, run as one batch before the cost functions ask:
// one material, one rollout a target. Where one table resists all strains at θ = 0, one that does
// not (ResistsAllStrains) fails without a rollout. Jacobians are by tangents where the
// parametrisation has one table, else by adjoints of the K radii (SolveMode::kStatic only).
class OutlineResiduals : public ceres::EvaluationCallback {
 public:
  // Pointers outlive the object.
  OutlineResiduals(Backend* backend, const MaterialParametrisation* parametrisation,
                   std::vector<Observation>* targets, const OutlineResidualOptions& options);

  // The same with other objects, which outlive it: what is known of the drapes stays.
  void Move(Backend* backend, std::vector<Observation>* targets);

  // The parameter block that the optimiser changes in place, shape [P].
  double* theta() { return theta_.data(); }
  int num_parameters() const { return static_cast<int>(theta_.size()); }
  int num_targets() const { return static_cast<int>(targets_->size()); }
  int num_angles() const { return static_cast<int>(targets_->front().radius.size()); }
  const MaterialParametrisation& parametrisation() const { return *parametrisation_; }
  const RolloutCounts& counts() const { return counts_; }

  void PrepareForEvaluation(bool with_jacobians, bool new_point) override;

  // Whether all drapes of the last evaluation were found, and on their branches.
  bool all_valid() const;
  // Residuals of target i, shape [K]. False when its rollout failed or left its branch.
  bool Copy(int i, double* residuals) const;
  // Their derivatives by `count` parameters from `first` on, row-major, shape [K, count].
  void CopyJacobian(int i, int first, int count, double* jacobian) const;

  // The drape of target i at the last evaluation, whether or not it stands [m], shape [3V].
  const Eigen::VectorXd& shape(int i) const { return evaluations_[i].x; }

  // A point at which shapes and Jacobians were found.
  struct Point {
    Eigen::VectorXd theta;
    std::vector<Eigen::VectorXd> x;         // by target [m], shape [3V]
    std::vector<RowMatrix> shape_by_theta;  // by target, where found by tangents, shape [3V, P]
    Eigen::VectorXd residual;               // [targets·K]
    Eigen::MatrixXd jacobian;               // [targets·K, P]
  };
  // The last one; none before has_accepted().
  bool has_accepted() const { return !accepted_.x.empty(); }
  const Point& accepted() const { return accepted_; }
  // Makes the drapes of that point the targets' starts.
  void StartFromAccepted();
  // Goes back to an earlier one.
  void Restore(Point point);

 private:
  struct Evaluation {
    bool valid = false;
    Eigen::VectorXd x;         // shape at the end
    RowMatrix x_by_log_entry;  // its derivative, where asked for and found by tangents
    Eigen::VectorXd residual;
    RowMatrix jacobian;
  };
  bool by_tangents() const { return parametrisation_->log_entries_by_theta() != nullptr; }
  void Evaluate(bool with_jacobians);
  void RunDynamic(const MaterialField& material, bool with_jacobians);
  void RunStatic(const MaterialField& material, bool with_jacobians);
  // Of drapes at rest, which are given as states.
  void FindTangents(const MaterialField& material, const std::vector<State>& drapes);
  void FindAdjoints(const MaterialField& material, const std::vector<State>& drapes);
  void FillResidual(int i, bool with_jacobian);
  bool ReadOutline(int i, Outline* outline) const;
  bool IsTooFar() const;
  bool LeftBranch(int i) const;
  void PredictShapes();
  std::vector<RolloutInput> MakeInputs(const MaterialField& material,
                                       const std::vector<State>& starts) const;
  void RestartFromLastShapes();
  void Accept();
  bool EvaluatedHere() const;

  Backend* backend_;
  const MaterialParametrisation* parametrisation_;
  std::vector<Observation>* targets_;
  OutlineResidualOptions options_;
  Eigen::VectorXd theta_, evaluated_theta_;
  std::vector<Evaluation> evaluations_;
  Point accepted_;
  std::vector<Eigen::VectorXd> predicted_x_;  // shapes at θ, linearised at the accepted point
  RolloutCounts counts_;
  bool keeps_resistance_;  // one table that resists all strains at θ = 0
};

}  // namespace drape
