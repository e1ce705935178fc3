// SPDX-License-Identifier: Apache-2.0
#include "solver/fit.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <glog/logging.h>

#include <chrono>

namespace drape {
namespace {

// The slice of one target: the batch has done the work.
class OutlineCost final : public ceres::CostFunction {
 public:
  OutlineCost(const RolloutBatch* batch, int target, int parameters) : batch_(batch), target_(target) {
    set_num_residuals(batch->num_angles());
    mutable_parameter_block_sizes()->push_back(parameters);
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    return batch_->Copy(target_, residuals, jacobians == nullptr ? nullptr : jacobians[0]);
  }

 private:
  const RolloutBatch* batch_;
  int target_;
};

class Monitor final : public ceres::IterationCallback {
 public:
  Monitor(const FitOptions& options, FitSummary* summary) : options_(options), summary_(summary) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    FitIteration it{s.iteration,  s.cost, s.step_norm, s.trust_region_radius, s.step_is_successful,
                    s.cumulative_time_in_seconds};
    summary_->iterations.push_back(it);
    if (options_.progress) options_.progress(it);
    if (options_.cancel != nullptr && options_.cancel->load()) return Stop(FitTermination::kCancelled);
    if (s.trust_region_radius * options_.max_damping < 1.0) return Stop(FitTermination::kDampingLimit);
    return ceres::SOLVER_CONTINUE;
  }
  bool stopped() const { return stopped_; }

 private:
  ceres::CallbackReturnType Stop(FitTermination why) {
    summary_->termination = why;
    stopped_ = true;
    return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

  const FitOptions& options_;
  FitSummary* summary_;
  bool stopped_ = false;
};

ceres::Solver::Options CeresOptions(const FitOptions& options, Monitor* monitor) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_QR;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.initial_trust_region_radius = 1.0 / options.initial_damping;
  ceres_options.function_tolerance = options.cost_tolerance;
  ceres_options.gradient_tolerance = 1e-12;
  ceres_options.parameter_tolerance = 1e-10;
  ceres_options.num_threads = 1;  // the batch is parallel, the copies are not worth it
  ceres_options.logging_type = ceres::SILENT;
  ceres_options.update_state_every_iteration = true;
  ceres_options.callbacks.push_back(monitor);
  // The batch's callback changes starts between evaluations, so the jacobi scaling of the first
  // Jacobian would be no better than none.
  ceres_options.jacobi_scaling = false;
  return ceres_options;
}

FitTermination FromCeres(const ceres::Solver::Summary& summary) {
  if (!summary.IsSolutionUsable()) return FitTermination::kFailed;
  return summary.termination_type == ceres::CONVERGENCE ? FitTermination::kConverged
                                                        : FitTermination::kIterationLimit;
}

}  // namespace

void FitOptions::Check() const {
  CHECK_GT(prior_sigma, 0.0) << "FitOptions::prior_sigma";
  CHECK_GE(max_iterations, 0) << "FitOptions::max_iterations";
  CHECK_GT(initial_damping, 0.0) << "FitOptions::initial_damping";
  CHECK_GT(max_damping, initial_damping) << "FitOptions::max_damping";
}

const char* ToString(FitTermination termination) {
  switch (termination) {
    case FitTermination::kConverged: return "converged";
    case FitTermination::kIterationLimit: return "iteration limit";
    case FitTermination::kDampingLimit: return "no smaller step lowers the cost";
    case FitTermination::kStalled: return "stalled at an unstable drape";
    case FitTermination::kCancelled: return "cancelled";
    case FitTermination::kFailed: return "failed";
  }
  return "unknown";
}

FitSummary Fit(RolloutBatch& batch, const FitOptions& options) {
  options.Check();
  const int size = batch.num_parameters();
  FitSummary summary;
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &batch;
  ceres::Problem problem(problem_options);
  for (int i = 0; i < batch.num_targets(); ++i)
    problem.AddResidualBlock(new OutlineCost(&batch, i, size), nullptr, batch.theta());
  const ceres::Matrix information =
      ceres::Matrix::Identity(size, size) / options.prior_sigma;
  problem.AddResidualBlock(new ceres::NormalPrior(information, ceres::Vector::Zero(size)), nullptr,
                           batch.theta());
  Monitor monitor(options, &summary);
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(CeresOptions(options, &monitor), &problem, &ceres_summary);
  if (!monitor.stopped()) summary.termination = FromCeres(ceres_summary);
  summary.message = ceres_summary.message;
  summary.counts = batch.counts();
  summary.seconds = ceres_summary.total_time_in_seconds;
  // Ceres fails where the Jacobian of an accepted step cannot be had: the point before still stands.
  if (!batch.has_accepted()) return summary;
  if (summary.termination == FitTermination::kFailed) summary.termination = FitTermination::kStalled;
  batch.StartFromAccepted();
  summary.theta = batch.accepted_theta();
  summary.initial_cost = ceres_summary.initial_cost;
  summary.final_cost = 0.5 * (batch.accepted_residual().squaredNorm() +
                              summary.theta.squaredNorm() / (options.prior_sigma * options.prior_sigma));
  summary.jacobian = batch.accepted_jacobian();
  return summary;
}

}  // namespace drape
