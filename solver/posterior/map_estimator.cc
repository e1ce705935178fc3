// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/map_estimator.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "losses/outline/outline.h"
#include "physics/util/errors.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/posterior/variational/pareto_smoothing.h"

namespace drape {
namespace {

constexpr int kModeIterations = 40;
constexpr double kUsualIterations = 10.0;  // of mode or distribution, for the progress line
constexpr int kSigmaRounds = 2;       // of mode and σ in alternation, from σ of the candidate
constexpr double kLeastSigma = 0.05;  // of an estimate: that of the measured outline [px]
constexpr double kMapTolerance = 1e-4;
constexpr int kNewtonFactor = 2;  // a sample lies further from the mode than a trial

}  // namespace

MapEstimator::MapEstimator(const FitProblem& problem, const StagedFitOptions& staged,
                           const PosteriorOptions& options, const FitCandidate& candidate,
                           const RunControl& control, PosteriorFit* fit)
    : problem_(problem),
      staged_(staged),
      options_(options),
      control_(control),
      candidate_fitter_(problem, staged, *problem.fine, control.cancel, 0),
      fit_(*fit) {
  options.Check();
  fit_.kind = options.kind;
  fit_.sigma_px = options.estimate_sigma ? std::max(kLeastSigma, candidate.profile_rms)
                                         : staged.residuals.sigma_px;
  SetHierarchy(candidate);
  SetSpecimens(candidate);
  mean_ = Eigen::VectorXd::Zero(fit_.hierarchy.num_latents());
  mean_.head(fit_.hierarchy.num_fabric()) = StartNumbers(candidate);
}

bool MapEstimator::Find() {
  const int rounds = options_.estimate_sigma ? kSigmaRounds : 1;
  for (int round = 0; round < rounds && !Cancelled(); ++round)
    if (!FindOnce(round, rounds)) return false;
  return !Cancelled();
}

void MapEstimator::SetHierarchy(const FitCandidate& candidate) {
  CHECK(problem_.specimens.empty() || problem_.specimens.size() == problem_.observations.size());
  for (int i = 0; i < int(problem_.observations.size()); ++i)
    fit_.specimen.push_back(problem_.specimens.empty() ? i : problem_.specimens[i] - 1);
  const bool hierarchical = options_.kind == PosteriorKind::kHierarchy;
  fit_.hierarchy = {.base = candidate.base,
                    .fabric = staged_.parameters,
                    .fabric_sigma = staged_.prior_sigma,
                    .specimen_stretch_sigma = hierarchical ? options_.specimen_stretch_sigma : 0.0,
                    .specimen_bend_sigma = hierarchical ? options_.specimen_bend_sigma : 0.0,
                    .specimens = 1 + *std::max_element(fit_.specimen.begin(), fit_.specimen.end())};
  if (!options_.prior) return;
  fit_.hierarchy.base = options_.prior->median;
  fit_.hierarchy.fabric_root = options_.prior->root;
}

// Those of the candidate's tables; where the prior's numbers cannot make them, of the nearest.
Eigen::VectorXd MapEstimator::StartNumbers(const FitCandidate& candidate) const {
  if (!options_.prior) return candidate.theta / staged_.prior_sigma;
  const MaterialField& median = options_.prior->median;
  Eigen::VectorXd log_factors = FindLogFactors(median, FittedMaterial(staged_, candidate));
  for (double& factor : log_factors)
    if (!std::isfinite(factor)) factor = 0.0;
  return options_.prior->root.triangularView<Eigen::Lower>().solve(
      MeanLogFactors(TyingMatrix(staged_.parameters), log_factors));
}

// With outlines at the posterior's angles.
void MapEstimator::SetSpecimens(const FitCandidate& candidate) {
  specimens_.resize(fit_.hierarchy.specimens);
  const std::vector<State> drapes = AtRest(candidate.shapes);
  for (std::size_t i = 0; i < drapes.size(); ++i) {
    Observation observation = problem_.observations[i];
    const auto radius = observation.MeasureRadius(options_.angles);
    if (!radius)
      throw InputError(observation.file, "no closed outline at " + std::to_string(options_.angles) +
                                             " angles, expected the silhouette of a drape");
    observation.radius = *radius;
    SpecimenDrapes& specimen = specimens_[fit_.specimen[i]];
    specimen.observations.push_back(std::move(observation));
    specimen.starts.push_back(drapes[i]);
  }
}

OutlineResidualOptions MapEstimator::MakeResidualOptions() const {
  OutlineResidualOptions options = candidate_fitter_.MakeResidualOptions();
  options.sigma_px = fit_.sigma_px;
  options.equilibrium.max_iterations *= kNewtonFactor;
  return options;
}

HierarchicalSamples MapEstimator::MakeSamples(int count, LostBranchPolicy policy) const {
  return {problem_.fine, fit_.hierarchy, specimens_, MakeResidualOptions(), count, policy};
}

VariationalOptions MapEstimator::MakeOptions(SampleKind kind, int iterations, double from,
                                             double to) const {
  VariationalOptions options;
  options.kind = kind;
  options.draws = options_.draws;
  options.rank = options_.rank;
  options.seed = options_.seed;
  options.trust_region.max_iterations = iterations;
  options.trust_region.cost_tolerance = kMapTolerance;
  options.trust_region.cancel = control_.cancel;
  options.trust_region.progress = [this, from, to](const FitIteration& iteration) {
    const double share = IterationShare(iteration.iteration, kUsualIterations);
    control_.Report(from + (to - from) * share, "posterior");
  };
  return options;
}

bool MapEstimator::FindOnce(int round, int rounds) {
  HierarchicalSamples one = MakeSamples(1, LostBranchPolicy::kRejectAtOnce);
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
  if (!one.Residuals(0, &residual, nullptr)) return false;
  StartFrom(one.Shapes(0));
  if (options_.estimate_sigma && round + 1 < rounds) EstimateSigma(residual);
  return true;
}

// The drapes of a point, specimen by specimen, become the starts.
void MapEstimator::StartFrom(const std::vector<Eigen::VectorXd>& shapes) {
  std::size_t next = 0;
  for (SpecimenDrapes& specimen : specimens_)
    for (State& start : specimen.starts) start.x = shapes[next++];
}

// σ² = (residual sum of squares) / (its degrees of freedom, less those of the mode: tr(1 − Σ) of
// its Laplace covariance).
void MapEstimator::EstimateSigma(const Eigen::VectorXd& residual) {
  const double determined = mean_.size() - fit_.mode.gaussian.Covariance().trace();
  const double freedom = std::max(1.0, double(residual.size()) - determined);
  fit_.sigma_px = std::max(kLeastSigma, fit_.sigma_px * residual.norm() / std::sqrt(freedom));
}

bool MapEstimator::ReportDrapes(Eigen::VectorXd u) {
  HierarchicalSamples sample = MakeSamples(1, LostBranchPolicy::kReject);
  if (!sample.StartAt(fit_.mode.gaussian.mean)) return false;
  sample.Prepare(u, false);
  fit_.reported_at_mode = sample.num_extrapolated() > 0;
  if (fit_.reported_at_mode) {
    u = fit_.mode.gaussian.mean;
    sample.Prepare(u, false);
    if (sample.num_extrapolated() > 0) return false;
  }
  const std::vector<Eigen::VectorXd> by_specimen = sample.Shapes(0);
  fit_.counts += sample.counts();
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
  fit->elbo_samples_valid = static_cast<int>(residuals.size());
  if (fit->elbo_samples_valid < kMinElboSamples) {
    fit->elbo = fit->elbo_error = fit->pareto_k = fit->sample_rms_px =
        std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const auto count = static_cast<double>(residuals[0].size());
  Eigen::ArrayXd weights(fit->elbo_samples_valid), squares(fit->elbo_samples_valid);
  for (int s = 0; s < fit->elbo_samples_valid; ++s) {
    squares[s] = residuals[s].squaredNorm();
    weights[s] = log_ratios[s] - 0.5 * squares[s];
  }
  weights -= count * std::log(fit->sigma_px * std::sqrt(2 * std::numbers::pi));
  fit->elbo = weights.mean();
  fit->elbo_error = std::sqrt((weights - fit->elbo).square().mean() / fit->elbo_samples_valid);
  fit->pareto_k = ParetoShape(weights.matrix());
  fit->sample_rms_px = fit->sigma_px * std::sqrt(squares.mean() / count);
}

}  // namespace drape
