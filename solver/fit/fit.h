// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ceres/solver.h>

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "solver/fit/lab/strip_residuals.h"
#include "solver/fit/observation.h"
#include "solver/fit/outline_residuals.h"
#include "solver/fit/parameters/parametrisation.h"

namespace drape {

// One iteration of the trust region, for logs and reports.
struct FitIteration {
  int iteration = 0;
  double cost = 0.0;          // ½ Σ residual², prior included
  double step_norm = 0.0;     // in log units
  double trust_radius = 0.0;  // 1/damping of Levenberg–Marquardt
  bool accepted = false;
  double seconds = 0.0;  // since the start of the stage
};

struct FitOptions {
  double prior_sigma = 1.0;  // of each log factor about its start
  int max_iterations = 30;
  double max_damping = 1e3;       // stop when the damping passes it
  double initial_damping = 1e-2;  // relative to the squared column norms
  // Squared column norms below this are damped as if they were this large: keeps numbers that the
  // data hardly feel from running away while the residuals are large.
  double least_scale = 1e-6;
  // All numbers are damped alike, in units of their prior, instead of by their columns' norms: for
  // fields, whose numbers are of one kind.
  bool unit_damping = false;
  double cost_tolerance = 1e-4;               // stop when |Δcost|/cost is below
  const std::atomic<bool>* cancel = nullptr;  // stop after the present iteration when it turns true
  std::function<void(const FitIteration&)> progress;

  void Check() const;  // programmer errors
};

enum class FitTermination {
  kConverged,
  kIterationLimit,
  kDampingLimit,  // no smaller step lowers the cost
  kStalled,       // no derivatives at the last step (an unstable drape): the point before is given
  kCancelled,
  kFailed  // not even the start could be evaluated
};
const char* ToString(FitTermination termination);

struct FitSummary {
  FitTermination termination = FitTermination::kFailed;
  std::string message;    // one sentence
  Eigen::VectorXd theta;  // best point
  double initial_cost = 0.0;
  double final_cost = 0.0;
  std::vector<FitIteration> iterations;
  RolloutCounts counts;
  // Of all targets, then of all points of tests, at the best point, shape [ΣK + N, P].
  Eigen::MatrixXd jacobian;
  double seconds = 0.0;
};

// Up to this many parameters the steps are Ceres's DENSE_QR. Beyond, CGNR: JᵀJ of m residuals with
// a prior and damping of one size is a matrix of rank m plus a multiple of 1, so that conjugate
// gradients end within m + 1 rounds at the solution of the dual system, (J·Jᵀ + c)·y = −r, without
// a matrix of [P, P].
inline constexpr int kMostDenseParameters = 1000;

// FitOptions::cost_tolerance of the last round: a valley of nearly equal drapes is long, and that
// round goes to its end.
inline constexpr double kLastCostTolerance = 1e-5;

// How Fit sets Ceres; without callbacks.
ceres::Solver::Options TrustRegionOptions(int parameters, const FitOptions& options);

// What Ceres's trust region did with a problem.
struct TrustRegionRun {
  FitTermination termination = FitTermination::kFailed;
  std::string message;  // one sentence
  double initial_cost = 0.0, final_cost = 0.0;
  std::vector<FitIteration> iterations;
  double seconds = 0.0;
};

// Runs it with TrustRegionOptions. Each iteration is told to options.progress; *options.cancel and
// options.max_damping end the run.
TrustRegionRun RunTrustRegion(ceres::Problem& problem, const FitOptions& options);

// Fits θ to all targets by Ceres's trust region (Levenberg–Marquardt) from batch.theta(). On return
// the targets' starts are the drapes of the best point. `tests`, if not null: mechanical tests of
// the same cloth, fitted jointly; a strip that cannot be computed refuses a step as a failed
// rollout does.
FitSummary Fit(OutlineResiduals& batch, const FitOptions& options, StripResiduals* tests = nullptr);

// The same for tests alone, from `theta`.
FitSummary FitStrips(StripResiduals& tests, const MaterialParametrisation& parametrisation,
                     const Eigen::VectorXd& theta, const FitOptions& options);

}  // namespace drape
