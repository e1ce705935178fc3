// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/solver.h>

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "physics/util/options/field.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/rollout_residuals.h"

namespace drape {

// One iteration of the trust region, for logs and reports.
struct FitIteration {
  int iteration = 0;
  double cost = 0.0;          // ½ Σ residual², prior included
  double trust_radius = 0.0;  // 1/damping of Levenberg–Marquardt
  bool accepted = false;
};

// Settings of Ceres's trust region by Levenberg–Marquardt.
struct TrustRegionOptions {
  int max_iterations = 30;
  double max_damping = 1e3;  // stop when damping > max_damping
  // At first, relative to the squared column norms: a large first step mostly leaves the branch.
  double initial_damping = 4.0;
  // Squared column norms below this are damped as if they were this large, so that parameters that
  // hardly affect the data do not run away while the residuals are large.
  double least_scale = 1e-6;
  // All parameters are damped alike, in units of their prior, instead of by their columns' norms:
  // for fields, whose parameters are of one kind.
  bool unit_damping = false;
  double cost_tolerance = 1e-4;               // stop when |Δcost| < cost_tolerance · cost
  const std::atomic<bool>* cancel = nullptr;  // stop after the present iteration when it turns true
  std::function<void(const FitIteration&)> progress = {};
};

struct FitOptions {
  double prior_sigma = 1.0;  // of each log factor about its start
  TrustRegionOptions trust_region;

  void Check() const;  // programmer errors
};

enum class FitTermination {
  kConverged,
  kIterationLimit,
  kDampingLimit,  // no smaller step lowers the cost
  kStalled,  // no derivatives at the last step (an unstable drape); the result is the one before
  kCancelled,
  kFailed  // not even the start could be evaluated
};
constexpr auto EnumNames(FitTermination) {
  return MakeNames<FitTermination>(
      {{FitTermination::kConverged, "converged"},
       {FitTermination::kIterationLimit, "iteration limit"},
       {FitTermination::kDampingLimit, "no smaller step lowers the cost"},
       {FitTermination::kStalled, "stalled at an unstable drape"},
       {FitTermination::kCancelled, "cancelled"},
       {FitTermination::kFailed, "failed"}});
}

// What Ceres's trust region did with a problem.
struct TrustRegionRun {
  FitTermination termination = FitTermination::kFailed;
  std::string message;  // one sentence
  double initial_cost = 0.0, final_cost = 0.0;
  std::vector<FitIteration> iterations;
  double seconds = 0.0;
};

struct FitSummary : TrustRegionRun {
  Eigen::VectorXd theta;  // best point
  RolloutCounts counts;
  // RolloutResiduals::Point::jacobian at the best point, shape [N, P].
  Eigen::MatrixXd jacobian;
  // ∂residual/∂(log entries of the table, then the numbers of θ beside the table) of motions
  // (FitLabInStages), shape [N, 39 + n].
  Eigen::MatrixXd by_entries;
};

// Up to this many parameters the steps use Ceres's DENSE_QR; above, CGNR: JᵀJ of m residuals with
// a prior and damping of one size is a matrix of rank m plus a multiple of 1, so conjugate
// gradients end within m + 1 iterations at the solution of the dual system, (J·Jᵀ + c)·y = −r,
// without a matrix of shape [P, P].
inline constexpr int kMaxDenseParameters = 1000;

// TrustRegionOptions::cost_tolerance of the last round: a valley of nearly equal drapes is long,
// and that round follows it to its end.
inline constexpr double kLastCostTolerance = 1e-5;

// Ceres's own options, without callbacks.
ceres::Solver::Options CeresOptions(int parameters, const TrustRegionOptions& options);

// Runs it with CeresOptions. Reports each iteration to options.progress; *options.cancel and
// options.max_damping end the run.
TrustRegionRun RunTrustRegion(ceres::Problem& problem, const TrustRegionOptions& options);

// Fits θ to all blocks by Ceres's trust region (Levenberg–Marquardt) from residuals.theta(). On
// return residuals.starts() are the drapes of the best point.
FitSummary Fit(RolloutResiduals& residuals, const FitOptions& options);

// Which combinations of the parameters the data determine: the singular values of the Jacobian of
// the (whitened) residuals. Along right singular vector i the data alone know θ to 1/value[i];
// where that is better than the prior's σ the direction is determined by the data.
struct Spectrum {
  Eigen::VectorXd values;      // descending, shape [P]; of K < P residuals the last are 0
  Eigen::MatrixXd directions;  // columns, shape [P, P]
  int determined = 0;          // values · prior_sigma > 1
};

// jacobian: ∂residual/∂θ, shape [K, P].
Spectrum ComputeSpectrum(const Eigen::MatrixXd& jacobian, double prior_sigma);

}  // namespace drape
