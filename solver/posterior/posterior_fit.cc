// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/posterior_fit.h"

#include <glog/logging.h>

#include <set>

#include "solver/posterior/map_estimator.h"

namespace drape {
namespace {

// The posterior is that of the branches seen, as if each went on straight beyond its end.
bool FindDistribution(const PosteriorOptions& options, const MapEstimator& mode,
                      PosteriorFit* fit) {
  HierarchicalSamples draws = mode.MakeSamples(options.draws, LostBranchPolicy::kTangent);
  if (mode.Cancelled() || !draws.StartAt(fit->mode.gaussian.mean)) return false;
  fit->posterior =
      FitPosterior(draws, fit->mode.gaussian,
                   mode.MakeOptions(SampleKind::kShared, options.iterations,
                                    MapEstimator::kModeShare, MapEstimator::kFitShare));
  fit->counts += draws.counts();
  fit->beyond = draws.num_extrapolated();
  return fit->posterior.termination != FitTermination::kFailed;
}

// ln p(r | u) + ln p(u) − ln q(u) of fresh draws.
void EstimateFreshElbo(const PosteriorOptions& options, const MapEstimator& mode,
                       PosteriorFit* fit) {
  const GaussianPosterior& q = fit->posterior.gaussian;
  HierarchicalSamples at_mode = mode.MakeSamples(1, LostBranchPolicy::kRefuse);
  if (!at_mode.StartAt(fit->mode.gaussian.mean)) return EstimateElbo({}, {}, fit);
  const auto fresh = at_mode.WithSamples(options.elbo_samples, LostBranchPolicy::kRefuse);
  const Eigen::MatrixXd standard =
      IndependentSamples(q.size(), options.elbo_samples, options.seed + 1);
  const Eigen::MatrixXd u = q.Draws(standard);
  fresh->Prepare(u, false);
  fit->counts += fresh->counts();
  const double volume = q.factor.diagonal().array().log().sum();
  std::vector<Eigen::VectorXd> residuals;
  std::vector<double> log_ratios;
  Eigen::VectorXd residual;
  for (int s = 0; s < options.elbo_samples; ++s) {
    if (!fresh->Copy(s, &residual, nullptr)) continue;
    residuals.push_back(residual);
    log_ratios.push_back(0.5 * (standard.col(s).squaredNorm() - u.col(s).squaredNorm()) + volume);
  }
  EstimateElbo(residuals, log_ratios, fit);
}

bool FitHierarchy(const PosteriorOptions& options, const MapEstimator& mode, PosteriorFit* fit) {
  if (!FindDistribution(options, mode, fit)) return false;
  EstimateFreshElbo(options, mode, fit);
  return !mode.Cancelled();
}

}  // namespace

void PosteriorOptions::Check(std::size_t targets) const {
  CHECK_GE(specimen_stretch_sigma, 0.0);
  CHECK_GE(specimen_bend_sigma, 0.0);
  CHECK_GT(element_sigma, 0.0);
  CHECK(draws >= 2 && draws % 2 == 0) << draws;
  CHECK_GE(elbo_samples, 25);
  CHECK_GT(angles, 2);
  if (specimen.empty()) return;
  CHECK_EQ(specimen.size(), targets);
  const std::set<int> names(specimen.begin(), specimen.end());
  CHECK(*names.begin() == 1 && *names.rbegin() == static_cast<int>(names.size()));
}

MaterialField PosteriorFit::FabricAt(const Eigen::VectorXd& u) const {
  Eigen::MatrixXd common = hierarchy.LogEntries(0);
  common.rightCols(common.cols() - hierarchy.num_fabric()).setZero();
  return TableParametrisation(hierarchy.base, common).Material(u);
}

PosteriorFit FitDrapePosterior(const FitProblem& problem, const StagedFitOptions& staged,
                               const PosteriorOptions& options, const FitCandidate& branch,
                               const StagedFitCallbacks& callbacks) {
  PosteriorFit fit;
  MapEstimator mode(problem, staged, options, branch, callbacks, &fit);
  if (!mode.Find()) return fit;
  const bool fitted = options.kind == PosteriorKind::kElements
                          ? FitElements(problem, options, mode, &fit)
                          : FitHierarchy(options, mode, &fit);
  if (!fitted || !mode.KeepDrapes(fit.posterior.gaussian.mean)) fit.shapes.clear();
  return fit;
}

}  // namespace drape
