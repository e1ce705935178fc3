// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/map_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "losses/outline/outline.h"
#include "physics/material/material_scaling.h"
#include "physics/util/errors.h"
#include "solver/posterior/variational/pareto_smoothing.h"

namespace drape {
namespace {

constexpr int kModeIterations = 40;
constexpr int kSigmaRounds = 2;       // the mode and σ by turns, from σ of the branch
constexpr double kLeastSigma = 0.05;  // [px], of a learned one: that of the outline's measurement
constexpr double kCostTolerance = 1e-4;
constexpr int kNewtonFactor = 2;  // a draw lies further from the mode than a trial

}  // namespace

MapEstimator::MapEstimator(const FitProblem& problem, const StagedFitOptions& staged,
                           const PosteriorOptions& options, const FitCandidate& branch,
                           const StagedFitCallbacks& callbacks, PosteriorFit* fit)
    : problem_(problem),
      staged_(staged),
      options_(options),
      callbacks_(callbacks),
      branch_fitter_(problem, staged, *problem.fine, callbacks.cancel, 0),
      fit_(*fit) {
  options.Check(problem.targets.size());
  fit_.kind = options.kind;
  fit_.sigma_px =
      options.estimate_sigma ? std::max(kLeastSigma, branch.profile_rms) : staged.sigma_px;
  SetHierarchy(branch);
  SetObservations(branch);
  mean_ = Eigen::VectorXd::Zero(fit_.hierarchy.num_latents());
  mean_.head(fit_.hierarchy.num_fabric()) = branch.theta / staged.prior_sigma;
}

bool MapEstimator::Find() {
  const int rounds = options_.estimate_sigma ? kSigmaRounds : 1;
  for (int round = 0; round < rounds && !Cancelled(); ++round)
    if (!FindOnce(round, rounds)) return false;
  return !Cancelled();
}

void MapEstimator::SetHierarchy(const FitCandidate& branch) {
  const int targets = static_cast<int>(problem_.targets.size());
  for (int i = 0; i < targets; ++i)
    fit_.specimen.push_back(options_.specimen.empty() ? i : options_.specimen[i] - 1);
  const bool hierarchical = options_.kind == PosteriorKind::kHierarchy;
  fit_.hierarchy = {.base = Scaled(problem_.material, branch.seed.stretch, branch.seed.bend),
                    .fabric = staged_.parameters,
                    .fabric_sigma = staged_.prior_sigma,
                    .specimen_stretch_sigma = hierarchical ? options_.specimen_stretch_sigma : 0.0,
                    .specimen_bend_sigma = hierarchical ? options_.specimen_bend_sigma : 0.0,
                    .specimens = 1 + *std::max_element(fit_.specimen.begin(), fit_.specimen.end())};
}

// The outlines anew at the posterior's angles.
void MapEstimator::SetObservations(const FitCandidate& branch) {
  targets_.resize(fit_.hierarchy.specimens);
  std::vector<Observation> all = branch_fitter_.WithStarts(branch);
  for (std::size_t i = 0; i < all.size(); ++i) {
    Outline outline;
    if (!OutlineFromImage(all[i].image, all[i].camera, options_.angles, &outline))
      throw InputError(all[i].file, "no closed outline at " + std::to_string(options_.angles) +
                                        " angles, expected the silhouette of a drape");
    all[i].radius = outline.radius;
    all[i].image = GrayImage();  // large, and copied with each draw
    targets_[fit_.specimen[i]].push_back(std::move(all[i]));
  }
}

OutlineResidualOptions MapEstimator::MakeResidualOptions() const {
  OutlineResidualOptions options = branch_fitter_.MakeResidualOptions();
  options.sigma_px = fit_.sigma_px;
  options.equilibrium.max_iterations *= kNewtonFactor;
  return options;
}

HierarchicalSamples MapEstimator::MakeSamples(int count, LostBranchPolicy beyond) const {
  return {problem_.fine, fit_.hierarchy, targets_, MakeResidualOptions(), count, beyond};
}

VariationalOptions MapEstimator::MakeOptions(SampleKind kind, int iterations, double from,
                                             double to) const {
  VariationalOptions options;
  options.kind = kind;
  options.draws = options_.draws;
  options.rank = options_.rank;
  options.seed = options_.seed;
  options.max_iterations = iterations;
  options.cost_tolerance = kCostTolerance;
  options.cancel = callbacks_.cancel;
  options.progress = [this, iterations, from, to](const FitIteration& iteration) {
    const double share = iteration.iteration / std::max(1.0, double(iterations));
    if (callbacks_.progress) callbacks_.progress("posterior", from + (to - from) * share, 0.0);
  };
  return options;
}

bool MapEstimator::FindOnce(int round, int rounds) {
  HierarchicalSamples one = MakeSamples(1, LostBranchPolicy::kRefuseAtOnce);
  if (!one.StartAt(mean_)) return false;
  const int n = fit_.hierarchy.num_latents();
  const GaussianPosterior start{mean_, Eigen::MatrixXd::Identity(n, n),
                                Eigen::MatrixXd::Identity(n, n)};
  fit_.mode =
      FitPosterior(one, start,
                   MakeOptions(SampleKind::kMode, kModeIterations, kModeShare * round / rounds,
                               kModeShare * (round + 1) / rounds));
  fit_.counts += one.counts();
  if (fit_.mode.termination == FitTermination::kFailed) return false;
  mean_ = fit_.mode.gaussian.mean;
  one.Prepare(mean_, false);
  Eigen::VectorXd residual;
  if (!one.Copy(0, &residual, nullptr)) return false;
  StartFrom(one.Shapes(0));
  if (options_.estimate_sigma && round + 1 < rounds) LearnSigma(residual);
  return true;
}

// The drapes of a point, specimen by specimen, become the targets' starts.
void MapEstimator::StartFrom(const std::vector<Eigen::VectorXd>& shapes) {
  std::size_t next = 0;
  for (std::vector<Observation>& of_specimen : targets_)
    for (Observation& target : of_specimen) target.start.x = shapes[next++];
}

// σ² = (residual sum of squares) / (its degrees of freedom), those of the mode taken off:
// tr(1 − Σ) of its Laplace covariance.
void MapEstimator::LearnSigma(const Eigen::VectorXd& residual) {
  const double determined = mean_.size() - fit_.mode.gaussian.Covariance().trace();
  const double freedom = std::max(1.0, double(residual.size()) - determined);
  fit_.sigma_px = std::max(kLeastSigma, fit_.sigma_px * residual.norm() / std::sqrt(freedom));
}

bool MapEstimator::KeepDrapes(Eigen::VectorXd u) {
  HierarchicalSamples draws = MakeSamples(1, LostBranchPolicy::kRefuse);
  if (!draws.StartAt(fit_.mode.gaussian.mean)) return false;
  draws.Prepare(u, false);
  fit_.shown_at_mode = draws.num_extrapolated() > 0;
  if (fit_.shown_at_mode) {
    u = fit_.mode.gaussian.mean;
    draws.Prepare(u, false);
    if (draws.num_extrapolated() > 0) return false;
  }
  const std::vector<Eigen::VectorXd> by_specimen = draws.Shapes(0);
  fit_.counts += draws.counts();
  fit_.shapes.resize(by_specimen.size());
  std::size_t next = 0;
  for (int p = 0; p < fit_.hierarchy.specimens; ++p)
    for (std::size_t i = 0; i < fit_.specimen.size(); ++i)
      if (fit_.specimen[i] == p) fit_.shapes[i] = by_specimen[next++];
  for (const int p : fit_.specimen)
    fit_.materials.push_back(
        TableParametrisation(fit_.hierarchy.base, fit_.hierarchy.LogEntries(p)).Material(u));
  return true;
}

void EstimateElbo(const std::vector<Eigen::VectorXd>& residuals,
                  const std::vector<double>& log_ratios, PosteriorFit* fit) {
  fit->fresh = static_cast<int>(residuals.size());
  if (fit->fresh < kLeastFresh) {
    fit->elbo = fit->elbo_error = fit->pareto_k = fit->draw_rms_px =
        std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const auto count = static_cast<double>(residuals[0].size());
  Eigen::ArrayXd weights(fit->fresh), squares(fit->fresh);
  for (int s = 0; s < fit->fresh; ++s) {
    squares[s] = residuals[s].squaredNorm();
    weights[s] = log_ratios[s] - 0.5 * squares[s];
  }
  weights -= count * std::log(fit->sigma_px * std::sqrt(2 * std::numbers::pi));
  fit->elbo = weights.mean();
  fit->elbo_error = std::sqrt((weights - fit->elbo).square().mean() / fit->fresh);
  fit->pareto_k = ParetoShape(weights.matrix());
  fit->draw_rms_px = fit->sigma_px * std::sqrt(squares.mean() / count);
}

}  // namespace drape
