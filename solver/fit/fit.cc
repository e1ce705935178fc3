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

// The residuals of one observation, which OutlineResiduals has computed.
class OutlineCost final : public ceres::CostFunction {
 public:
  OutlineCost(const OutlineResiduals* outlines, int observation, const ParameterBlocks& blocks)
      : outlines_(outlines), target_(observation) {
    set_num_residuals(outlines->num_angles());
    *mutable_parameter_block_sizes() = blocks.sizes;
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    if (!outlines_->Residuals(target_, residuals)) return false;
    int first = 0;
    for (std::size_t b = 0; jacobians != nullptr && b < parameter_block_sizes().size(); ++b) {
      const int size = parameter_block_sizes()[b];
      if (jacobians[b] != nullptr) outlines_->CopyJacobian(target_, first, size, jacobians[b]);
      first += size;
    }
    return true;
  }

 private:
  const OutlineResiduals* outlines_;
  int target_;
};

// All points of the laboratory measurements, computed when Ceres calls for them: strips are small.
class StripCost final : public ceres::CostFunction {
 public:
  // accepted: where Ceres last had a Jacobian; may be null.
  StripCost(StripResiduals* strips, const MaterialParametrisation* parametrisation,
            Eigen::VectorXd* accepted)
      : strips_(strips), parametrisation_(parametrisation), accepted_(accepted) {
    set_num_residuals(strips->num_points());
    mutable_parameter_block_sizes()->push_back(parametrisation->size());
  }
  bool Evaluate(double const* const* theta, double* residuals, double** jacobians) const override {
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    Eigen::VectorXd residual;
    RowMatrix jacobian;
    const Eigen::Map<const Eigen::VectorXd> here(theta[0], parametrisation_->size());
    if (!strips_->Evaluate(*parametrisation_, here, &residual, with_jacobian ? &jacobian : nullptr))
      return false;
    if (with_jacobian && accepted_ != nullptr) *accepted_ = here;
    std::copy_n(residual.data(), residual.size(), residuals);
    if (with_jacobian) std::copy_n(jacobian.data(), jacobian.size(), jacobians[0]);
    return true;
  }

 private:
  StripResiduals* strips_;
  const MaterialParametrisation* parametrisation_;
  Eigen::VectorXd* accepted_;
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

// Adds the strips to a summary that holds the best θ. False when they cannot be computed there.
bool AppendStrips(StripResiduals& strips, const MaterialParametrisation& parametrisation,
                  FitSummary* summary) {
  Eigen::VectorXd residual;
  RowMatrix jacobian;
  if (!strips.Evaluate(parametrisation, summary->theta, &residual, &jacobian)) return false;
  summary->final_cost += 0.5 * residual.squaredNorm();
  Eigen::MatrixXd both(summary->jacobian.rows() + jacobian.rows(), jacobian.cols());
  both << summary->jacobian, jacobian;
  summary->jacobian = std::move(both);
  return true;
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

FitSummary Fit(OutlineResiduals& outlines, const FitOptions& options, StripResiduals* strips) {
  options.Check();
  FitSummary summary;
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &outlines;
  ceres::Problem problem(problem_options);
  const ParameterBlocks blocks(outlines.theta(), outlines.num_parameters());
  for (int i = 0; i < outlines.num_observations(); ++i)
    problem.AddResidualBlock(new OutlineCost(&outlines, i, blocks), nullptr, blocks.starts);
  if (strips != nullptr)
    problem.AddResidualBlock(new StripCost(strips, &outlines.parametrisation(), nullptr), nullptr,
                             outlines.theta());
  AddPrior(problem, blocks, options);
  static_cast<TrustRegionRun&>(summary) = RunTrustRegion(problem, options.trust_region);
  summary.final_cost = 0.0;
  summary.counts = outlines.counts();
  // Ceres fails where an accepted step has no Jacobian: the result is the point before.
  if (!outlines.has_accepted()) return summary;
  if (summary.termination == FitTermination::kFailed)
    summary.termination = FitTermination::kStalled;
  outlines.StartFromAccepted();
  summary.theta = outlines.accepted().theta;
  summary.final_cost =
      0.5 * (outlines.accepted().residual.squaredNorm() +
             summary.theta.squaredNorm() / (options.prior_sigma * options.prior_sigma));
  summary.jacobian = outlines.accepted().jacobian;
  if (strips != nullptr && !AppendStrips(*strips, outlines.parametrisation(), &summary))
    summary.termination = FitTermination::kFailed;
  return summary;
}

FitSummary FitStrips(StripResiduals& strips, const MaterialParametrisation& parametrisation,
                     const Eigen::VectorXd& theta, const FitOptions& options) {
  options.Check();
  const int size = parametrisation.size();
  FitSummary summary;
  Eigen::VectorXd block = theta;
  ceres::Problem problem;
  problem.AddResidualBlock(new StripCost(&strips, &parametrisation, &summary.theta), nullptr,
                           block.data());
  AddPrior(problem, ParameterBlocks(block.data(), size), options);
  static_cast<TrustRegionRun&>(summary) = RunTrustRegion(problem, options.trust_region);
  summary.final_cost = 0.0;
  if (summary.theta.size() == 0) return summary;
  if (summary.termination == FitTermination::kFailed)
    summary.termination = FitTermination::kStalled;
  summary.final_cost =
      0.5 * summary.theta.squaredNorm() / (options.prior_sigma * options.prior_sigma);
  summary.jacobian.resize(0, size);
  if (!AppendStrips(strips, parametrisation, &summary))
    summary.termination = FitTermination::kFailed;
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
