// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior_fit.h"

#include <glog/logging.h>

#include <set>

#include "solver/posterior_mode.h"

namespace drape {
namespace {

// Draws start near the mode, nearer where their drapes do not stand, and spread from there. The
// posterior is that of the branches seen: where one of them ends, so do the draws.
bool FindDistribution(const PosteriorOptions& options, const PosteriorMode& mode,
                      PosteriorFit* fit) {
  for (const double deviation : {0.3, 0.1, 0.03, 0.01}) {
    DrapeDraws draws = mode.MakeDraws(options.draws);
    if (mode.Cancelled() || !draws.StartAt(fit->mode.posterior.mean)) return false;
    GaussianPosterior start = fit->mode.posterior;
    start.factor.diagonal() = start.factor.diagonal().cwiseMin(deviation).eval();
    fit->posterior =
        FitPosterior(draws, start,
                     mode.OptionsOf(DrawKind::kShared, options.iterations,
                                    PosteriorMode::kModeShare, PosteriorMode::kFitShare));
    fit->counts += draws.counts();
    if (fit->posterior.termination != FitTermination::kFailed) return true;
  }
  return false;
}

// ln p(r | u) + ln p(u) − ln q(u) of fresh draws.
bool ScoreFreshDraws(const PosteriorOptions& options, const PosteriorMode& mode,
                     PosteriorFit* fit) {
  const GaussianPosterior& q = fit->posterior.posterior;
  DrapeDraws mean = mode.MakeDraws(1);
  if (!mean.StartAt(q.mean)) return false;
  const auto fresh = mean.WithDraws(options.fresh_draws);
  const Eigen::MatrixXd standard =
      IndependentDraws(q.size(), options.fresh_draws, options.seed + 1);
  const Eigen::MatrixXd u = q.Draws(standard);
  fresh->Prepare(u, false);
  fit->counts += fresh->counts();
  const double volume = q.factor.diagonal().array().log().sum();
  std::vector<Eigen::VectorXd> residuals;
  std::vector<double> log_ratios;
  Eigen::VectorXd residual;
  for (int s = 0; s < options.fresh_draws; ++s) {
    if (!fresh->Copy(s, &residual, nullptr)) continue;
    residuals.push_back(residual);
    log_ratios.push_back(0.5 * (standard.col(s).squaredNorm() - u.col(s).squaredNorm()) + volume);
  }
  return ScoreDraws(residuals, log_ratios, fit);
}

bool FitHierarchy(const PosteriorOptions& options, const PosteriorMode& mode, PosteriorFit* fit) {
  return FindDistribution(options, mode, fit) && ScoreFreshDraws(options, mode, fit);
}

}  // namespace

void PosteriorOptions::Check(std::size_t targets) const {
  CHECK_GE(specimen_stretch_sigma, 0.0);
  CHECK_GE(specimen_bend_sigma, 0.0);
  CHECK_GT(element_sigma, 0.0);
  CHECK(draws >= 2 && draws % 2 == 0) << draws;
  CHECK_GE(fresh_draws, 25);
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
                               const PosteriorOptions& options, const BranchFit& branch,
                               const StagedFitCallbacks& callbacks) {
  PosteriorFit fit;
  PosteriorMode mode(problem, staged, options, branch, callbacks, &fit);
  if (!mode.Find()) return fit;
  const bool fitted = options.kind == PosteriorKind::kElements
                          ? FitElements(problem, options, mode, &fit)
                          : FitHierarchy(options, mode, &fit);
  if (!fitted || !mode.KeepDrapes(fit.posterior.posterior.mean)) fit.shapes.clear();
  return fit;
}

}  // namespace drape
