// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_fit.h"

#include "solver/posterior/element_posterior.h"
#include "solver/posterior/map_estimator.h"

namespace drape {
namespace {

// The posterior given the observed branches, each extrapolated linearly past its end.
bool FindDistribution(const PosteriorOptions& options, const MapEstimator& mode,
                      PosteriorFit* fit) {
  HierarchicalSamples draws = mode.MakeSamples(options.draws, LostBranchPolicy::kExtrapolate);
  if (mode.Cancelled() || !draws.StartAt(fit->mode.gaussian.mean)) return false;
  fit->distribution =
      FitPosterior(draws, fit->mode.gaussian,
                   mode.MakeOptions(SampleKind::kShared, options.iterations,
                                    MapEstimator::kModeShare, MapEstimator::kFitShare));
  fit->counts += draws.counts();
  fit->num_extrapolated = draws.num_extrapolated();
  return fit->distribution.termination != FitTermination::kFailed;
}

// ln p(r | u) + ln p(u) − ln q(u) of independent samples.
void EstimateElboOfFit(const PosteriorOptions& options, const MapEstimator& mode,
                       PosteriorFit* fit) {
  const GaussianPosterior& q = fit->distribution.gaussian;
  HierarchicalSamples at_mode = mode.MakeSamples(1, LostBranchPolicy::kReject);
  if (!at_mode.StartAt(fit->mode.gaussian.mean)) return EstimateElbo({}, {}, fit);
  const auto independent = at_mode.WithSamples(options.elbo_samples, LostBranchPolicy::kReject);
  const Eigen::MatrixXd standard =
      IndependentSamples(q.size(), options.elbo_samples, options.seed + 1);
  const Eigen::MatrixXd u = q.Draws(standard);
  independent->Prepare(u, false);
  fit->counts += independent->counts();
  const double volume = q.factor.diagonal().array().log().sum();
  std::vector<Eigen::VectorXd> residuals;
  std::vector<double> log_ratios;
  Eigen::VectorXd residual;
  for (int s = 0; s < options.elbo_samples; ++s) {
    if (!independent->Residuals(s, &residual, nullptr)) continue;
    residuals.push_back(residual);
    log_ratios.push_back(0.5 * (standard.col(s).squaredNorm() - u.col(s).squaredNorm()) + volume);
  }
  EstimateElbo(residuals, log_ratios, fit);
}

bool FitHierarchy(const PosteriorOptions& options, const MapEstimator& mode, PosteriorFit* fit) {
  if (!FindDistribution(options, mode, fit)) return false;
  EstimateElboOfFit(options, mode, fit);
  return !mode.Cancelled();
}

}  // namespace

PosteriorFit FitDrapePosterior(const FitProblem& problem, const StagedFitOptions& staged,
                               const PosteriorOptions& options, const FitCandidate& candidate,
                               const RunControl& control) {
  PosteriorFit fit;
  MapEstimator mode(problem, staged, options, candidate, control, &fit);
  if (!mode.Find()) return fit;
  const bool fitted = options.kind == PosteriorKind::kElements
                          ? FitElements(problem, options, mode, &fit)
                          : FitHierarchy(options, mode, &fit);
  if (!fitted || !mode.ReportDrapes(fit.distribution.gaussian.mean)) fit.shapes.clear();
  return fit;
}

}  // namespace drape
