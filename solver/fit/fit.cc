// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/fit.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <glog/logging.h>

#include <Eigen/SVD>
#include <algorithm>
#include <utility>

namespace drape {
namespace {

// θ as parameter blocks of Ceres: one, or many for conjugate gradients, since the prior of a block
// is a dense matrix.
struct ParameterBlocks {
  explicit ParameterBlocks(double* theta, int size) {
    constexpr int kLargest = 64;
    const int most = size > kMaxDenseParameters ? kLargest : size;
    for (int first = 0; first < size; first += most) {
      starts.push_back(theta + first);
      sizes.push_back(std::min(most, size - first));
    }
  }
  std::vector<double*> starts;
  std::vector<int> sizes;
};

// Rows of the residuals of one block, which RolloutResiduals has computed.
class RolloutCost final : public ceres::CostFunction {
 public:
  RolloutCost(const RolloutResiduals* residuals, int block, int first_row, int rows,
              const ParameterBlocks& parameters)
      : residuals_(residuals), block_(block), first_row_(first_row) {
    set_num_residuals(rows);
    *mutable_parameter_block_sizes() = parameters.sizes;
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    if (!residuals_->valid(block_)) return false;
    const int rows = num_residuals();
    Eigen::Map<Eigen::VectorXd>(residuals, rows) =
        residuals_->residual(block_).segment(first_row_, rows);
    int first = 0;
    for (std::size_t b = 0; jacobians != nullptr && b < parameter_block_sizes().size(); ++b) {
      const int size = parameter_block_sizes()[b];
      if (jacobians[b] != nullptr)
        Eigen::Map<RowMatrix>(jacobians[b], rows, size) =
            residuals_->jacobian(block_).block(first_row_, first, rows, size);
      first += size;
    }
    return true;
  }

 private:
  const RolloutResiduals* residuals_;
  int block_, first_row_;
};

class Monitor final : public ceres::IterationCallback {
 public:
  Monitor(const TrustRegionOptions& options, TrustRegionRun* run) : options_(options), run_(run) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    run_->iterations.push_back({s.iteration, s.cost, s.trust_region_radius, s.step_is_successful});
    if (options_.progress) options_.progress(run_->iterations.back());
    if (options_.cancel != nullptr && options_.cancel->load())
      return Stop(FitTermination::kCancelled);
    if (s.trust_region_radius * options_.max_damping < 1.0)
      return Stop(FitTermination::kDampingLimit);
    return ceres::SOLVER_CONTINUE;
  }
  bool stopped() const { return stopped_; }

 private:
  ceres::CallbackReturnType Stop(FitTermination why) {
    run_->termination = why;
    stopped_ = true;
    return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

  const TrustRegionOptions& options_;
  TrustRegionRun* run_;
  bool stopped_ = false;
};

void UseConjugateGradients(ceres::Solver::Options* options) {
  options->linear_solver_type = ceres::CGNR;
  options->preconditioner_type = ceres::IDENTITY;
  options->max_linear_solver_iterations = 1000;
  options->eta = 1e-10;
}

FitTermination FromCeres(const ceres::Solver::Summary& summary) {
  if (!summary.IsSolutionUsable()) return FitTermination::kFailed;
  return summary.termination_type == ceres::CONVERGENCE ? FitTermination::kConverged
                                                        : FitTermination::kIterationLimit;
}

void AddPrior(ceres::Problem& problem, const ParameterBlocks& blocks, const FitOptions& options) {
  for (std::size_t b = 0; b < blocks.sizes.size(); ++b) {
    const int size = blocks.sizes[b];
    const ceres::Matrix information = ceres::Matrix::Identity(size, size) / options.prior_sigma;
    problem.AddResidualBlock(new ceres::NormalPrior(information, ceres::Vector::Zero(size)),
                             nullptr, blocks.starts[b]);
  }
}

// One cost for each sight of a block; under a robust loss, one for each group of its rows.
void AddCosts(ceres::Problem& problem, const ParameterBlocks& parameters,
              const RolloutResiduals& residuals) {
  for (int block = 0; block < residuals.num_blocks(); ++block) {
    int row = 0;
    for (const Sight& sight : residuals.block(block).sights) {
      const int rows = static_cast<int>(sight.data.size());
      const int group = sight.loss == nullptr ? rows : sight.readouts.front()->group();
      for (const int end = row + rows; row < end; row += group)
        problem.AddResidualBlock(new RolloutCost(&residuals, block, row, group, parameters),
                                 sight.loss.get(), parameters.starts);
    }
  }
}

}  // namespace

void FitOptions::Check() const {
  CHECK_GT(prior_sigma, 0.0);
  CHECK_GE(trust_region.max_iterations, 0);
  CHECK_GT(trust_region.initial_damping, 0.0);
  CHECK_GT(trust_region.max_damping, trust_region.initial_damping);
  CHECK(trust_region.least_scale >= 0.0 && trust_region.cost_tolerance >= 0.0);
}

ceres::Solver::Options CeresOptions(int parameters, const TrustRegionOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_QR;
  if (parameters > kMaxDenseParameters) UseConjugateGradients(&ceres_options);
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.initial_trust_region_radius = 1.0 / options.initial_damping;
  ceres_options.min_lm_diagonal = options.unit_damping ? 1.0 : options.least_scale;
  if (options.unit_damping) ceres_options.max_lm_diagonal = 1.0;
  ceres_options.function_tolerance = options.cost_tolerance;
  ceres_options.gradient_tolerance = 1e-12;
  ceres_options.parameter_tolerance = 1e-10;
  ceres_options.num_threads = 1;  // the rollouts are parallel, copies need not be
  ceres_options.logging_type = ceres::SILENT;
  ceres_options.update_state_every_iteration = true;
  // The evaluation callback changes starts between evaluations, so the Jacobi scaling of the first
  // Jacobian would be no better than none.
  ceres_options.jacobi_scaling = false;
  return ceres_options;
}

TrustRegionRun RunTrustRegion(ceres::Problem& problem, const TrustRegionOptions& options) {
  TrustRegionRun run;
  Monitor monitor(options, &run);
  ceres::Solver::Summary summary;
  ceres::Solver::Options ceres_options = CeresOptions(problem.NumParameters(), options);
  ceres_options.callbacks.push_back(&monitor);
  ceres::Solve(ceres_options, &problem, &summary);
  if (!monitor.stopped()) run.termination = FromCeres(summary);
  run.message = summary.message;
  run.initial_cost = summary.initial_cost;
  run.final_cost = summary.final_cost;
  run.seconds = summary.total_time_in_seconds;
  return run;
}

FitSummary Fit(RolloutResiduals& residuals, const FitOptions& options) {
  options.Check();
  FitSummary summary;
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &residuals;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  const ParameterBlocks parameters(residuals.theta(), residuals.num_parameters());
  AddCosts(problem, parameters, residuals);
  AddPrior(problem, parameters, options);
  static_cast<TrustRegionRun&>(summary) = RunTrustRegion(problem, options.trust_region);
  summary.final_cost = 0.0;
  summary.counts = residuals.counts();
  // Ceres fails where an accepted step has no Jacobian: the result is the point before.
  if (!residuals.has_accepted()) return summary;
  if (summary.termination == FitTermination::kFailed)
    summary.termination = FitTermination::kStalled;
  residuals.StartFromAccepted();
  const RolloutResiduals::Point& accepted = residuals.accepted();
  summary.theta = accepted.theta;
  summary.final_cost = accepted.cost + 0.5 * accepted.theta.squaredNorm() /
                                           (options.prior_sigma * options.prior_sigma);
  summary.jacobian = accepted.jacobian;
  return summary;
}

Spectrum ComputeSpectrum(const Eigen::MatrixXd& jacobian, double prior_sigma) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian, Eigen::ComputeFullV);
  Spectrum spectrum;
  spectrum.values = Eigen::VectorXd::Zero(jacobian.cols());
  spectrum.values.head(svd.singularValues().size()) = svd.singularValues();
  spectrum.directions = svd.matrixV();
  spectrum.determined = static_cast<int>((spectrum.values.array() * prior_sigma > 1.0).count());
  return spectrum;
}

}  // namespace drape
