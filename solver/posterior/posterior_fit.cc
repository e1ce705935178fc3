// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_fit.h"

#include <cmath>
#include <numbers>
#include <utility>

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

// For each observation, how many of its sample's outlines come before it: those of a sample go
// specimen by specimen.
std::vector<Eigen::Index> OutlinePlaces(const std::vector<int>& specimen, int specimens) {
  std::vector<Eigen::Index> places(specimen.size());
  Eigen::Index next = 0;
  for (int p = 0; p < specimens; ++p)
    for (std::size_t i = 0; i < specimen.size(); ++i)
      if (specimen[i] == p) places[i] = next++;
  return places;
}

// Collects samples of a fit with the outlines that their residuals (r − r_image)/σ stand for.
class SampleCollector {
 public:
  SampleCollector(const MapEstimator& mode, const PosteriorFit& fit, int drawn)
      : fit_(fit), places_(OutlinePlaces(fit.specimen, fit.hierarchy.specimens)) {
    std::vector<const Observation*> by_specimen;
    for (const SpecimenDrapes& specimen : mode.specimens())
      for (const Observation& each : specimen.observations) by_specimen.push_back(&each);
    stored_.drawn = drawn;
    for (const Eigen::Index place : places_) {
      const Observation& image = *by_specimen[place];
      const double metre = image.outline_camera().pixels_per_metre();
      stored_.images.push_back({image.name, fit.sigma_px / metre, image.radius / metre});
    }
  }
  void Add(const Eigen::VectorXd& u, const Eigen::VectorXd& residual, double log_prior,
           double log_density) {
    const Eigen::Index angles = stored_.angles();
    StoredSamples::Sample sample{fit_.hierarchy.LatentRoot() * u, log_prior, log_density,
                                 Eigen::MatrixXd(angles, places_.size())};
    for (std::size_t i = 0; i < places_.size(); ++i)
      sample.radius.col(i) =
          stored_.images[i].radius +
          stored_.images[i].sigma * residual.segment(angles * places_[i], angles);
    stored_.samples.push_back(std::move(sample));
  }
  StoredSamples Take() { return std::move(stored_); }

 private:
  const PosteriorFit& fit_;
  const std::vector<Eigen::Index> places_;
  StoredSamples stored_;
};

// ln p(r | u) + ln p(u) − ln q(u) of independent samples.
void EstimateElboOfFit(const PosteriorOptions& options, const MapEstimator& mode,
                       PosteriorFit* fit) {
  const GaussianPosterior& q = fit->distribution.gaussian;
  fit->samples.emplace();
  HierarchicalSamples at_mode = mode.MakeSamples(1, LostBranchPolicy::kReject);
  if (!at_mode.StartAt(fit->mode.gaussian.mean)) return EstimateElbo({}, {}, fit);
  const auto independent = at_mode.WithSamples(options.elbo_samples, LostBranchPolicy::kReject);
  const Eigen::MatrixXd standard =
      IndependentSamples(q.size(), options.elbo_samples, options.seed + 1);
  const Eigen::MatrixXd u = q.Draws(standard);
  independent->Prepare(u, false);
  fit->counts += independent->counts();
  const double volume = q.factor.diagonal().array().log().sum();
  const double constant = 0.5 * q.size() * std::log(2 * std::numbers::pi);
  SampleCollector collector(mode, *fit, options.elbo_samples);
  std::vector<Eigen::VectorXd> residuals;
  std::vector<double> log_ratios;
  Eigen::VectorXd residual;
  for (int s = 0; s < options.elbo_samples; ++s) {
    if (!independent->Residuals(s, &residual, nullptr)) continue;
    const double log_prior = -0.5 * u.col(s).squaredNorm() - constant;
    const double log_density = -0.5 * standard.col(s).squaredNorm() - volume - constant;
    residuals.push_back(residual);
    log_ratios.push_back(log_prior - log_density);
    collector.Add(u.col(s), residual, log_prior, log_density);
  }
  EstimateElbo(residuals, log_ratios, fit);
  fit->samples = collector.Take();
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
