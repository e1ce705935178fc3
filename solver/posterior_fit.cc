// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior_fit.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "losses/outline.h"
#include "physics/errors.h"
#include "physics/material_scaling.h"
#include "solver/branch_fit.h"
#include "solver/pareto_smoothing.h"

namespace drape {
namespace {

constexpr int kModeIterations = 40;
constexpr int kSigmaRounds = 3;       // the mode and σ by turns
constexpr double kLeastSigma = 0.05;  // [px], of a learned one: that of the outline's measurement
constexpr double kCostTolerance = 1e-4;
constexpr int kNewtonFactor = 2;  // a draw lies further from the mode than a trial

class PosteriorFitter {
 public:
  PosteriorFitter(const FitProblem& problem, const StagedFitOptions& staged,
                  const PosteriorOptions& options, const BranchFit& branch,
                  const StagedFitCallbacks& callbacks)
      : problem_(problem),
        staged_(staged),
        options_(options),
        callbacks_(callbacks),
        branch_fitter_(problem, staged, *problem.fine, callbacks.cancel, 0) {
    options.Check(problem.targets.size());
    fit_.sigma_px = staged.sigma_px;
    SetHierarchy(branch);
    SetTargets(branch);
    mean_ = Eigen::VectorXd::Zero(fit_.hierarchy.num_latents());
    mean_.head(fit_.hierarchy.num_fabric()) = branch.theta / staged.prior_sigma;
  }

  PosteriorFit Run() {
    const int rounds = options_.learn_sigma ? kSigmaRounds : 1;
    for (int round = 0; round < rounds && !Cancelled(); ++round)
      if (!FindMode(round, rounds)) return std::move(fit_);
    if (Cancelled() || !FindDistribution()) return std::move(fit_);
    ScoreFreshDraws();
    return std::move(fit_);
  }

 private:
  bool Cancelled() const { return callbacks_.cancel != nullptr && callbacks_.cancel->load(); }

  void SetHierarchy(const BranchFit& branch) {
    const int targets = static_cast<int>(problem_.targets.size());
    for (int i = 0; i < targets; ++i)
      fit_.specimen.push_back(options_.specimen.empty() ? i : options_.specimen[i] - 1);
    fit_.hierarchy = {
        .base = Scaled(problem_.material, branch.seed.stretch, branch.seed.bend),
        .fabric = staged_.parameters,
        .fabric_sigma = staged_.prior_sigma,
        .specimen_stretch_sigma = options_.specimen_stretch_sigma,
        .specimen_bend_sigma = options_.specimen_bend_sigma,
        .specimens = 1 + *std::max_element(fit_.specimen.begin(), fit_.specimen.end())};
  }

  // The outlines anew at the posterior's angles.
  void SetTargets(const BranchFit& branch) {
    targets_.resize(fit_.hierarchy.specimens);
    std::vector<Target> all = branch_fitter_.WithStarts(branch);
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

  DrapeDraws MakeDraws(int count, BeyondBranch beyond) const {
    BatchOptions options = branch_fitter_.BatchOptionsOf();
    options.sigma_px = fit_.sigma_px;
    options.equilibrium.max_iterations *= kNewtonFactor;
    return {problem_.fine, fit_.hierarchy, targets_, options, count, beyond};
  }

  VariationalOptions OptionsOf(DrawKind kind, int iterations, double from, double to) const {
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

  bool FindMode(int round, int rounds) {
    DrapeDraws one = MakeDraws(1, BeyondBranch::kRefuse);
    if (!one.StartAt(mean_)) return false;
    const int n = fit_.hierarchy.num_latents();
    const GaussianPosterior start{mean_, Eigen::MatrixXd::Identity(n, n),
                                  Eigen::MatrixXd::Identity(n, n)};
    fit_.mode =
        FitPosterior(one, start,
                     OptionsOf(DrawKind::kMode, kModeIterations, kModeShare * round / rounds,
                               kModeShare * (round + 1) / rounds));
    fit_.counts += one.counts();
    if (fit_.mode.termination == FitTermination::kFailed) return false;
    mean_ = fit_.mode.posterior.mean;
    one.Prepare(mean_, false);
    Eigen::VectorXd residual;
    if (!one.Copy(0, &residual, nullptr)) return false;
    StartFrom(one.Shapes(0));
    if (options_.learn_sigma && round + 1 < rounds) LearnSigma(residual);
    return true;
  }

  // The drapes of a point, specimen by specimen, become the targets' starts.
  void StartFrom(const std::vector<Eigen::VectorXd>& shapes) {
    std::size_t next = 0;
    for (std::vector<Target>& of_specimen : targets_)
      for (Target& target : of_specimen) target.start.x = shapes[next++];
  }

  // σ² = (residual sum of squares) / (its degrees of freedom), those of the mode taken off:
  // tr(1 − Σ) of its Laplace covariance.
  void LearnSigma(const Eigen::VectorXd& residual) {
    const double determined = mean_.size() - fit_.mode.posterior.Covariance().trace();
    const double freedom = std::max(1.0, double(residual.size()) - determined);
    fit_.sigma_px = std::max(kLeastSigma, fit_.sigma_px * residual.norm() / std::sqrt(freedom));
  }

  // The posterior is that of the branches seen, as if each went on straight beyond its end.
  bool FindDistribution() {
    DrapeDraws draws = MakeDraws(options_.draws, BeyondBranch::kTangent);
    if (Cancelled() || !draws.StartAt(mean_)) return false;
    fit_.posterior = FitPosterior(
        draws, fit_.mode.posterior,
        OptionsOf(DrawKind::kShared, options_.iterations, kModeShare, kFitShare));
    fit_.counts += draws.counts();
    fit_.beyond = draws.num_beyond();
    return fit_.posterior.termination != FitTermination::kFailed;
  }

  // ln p(r | u) + ln p(u) − ln q(u) of fresh draws, and the drapes of the mean.
  void ScoreFreshDraws() {
    const GaussianPosterior& q = fit_.posterior.posterior;
    DrapeDraws mean = MakeDraws(1, BeyondBranch::kRefuse);
    if (!mean.StartAt(q.mean)) return;
    mean.Prepare(q.mean, false);
    const auto fresh = mean.WithDraws(options_.fresh_draws, BeyondBranch::kRefuse);
    const Eigen::MatrixXd standard =
        IndependentDraws(q.size(), options_.fresh_draws, options_.seed + 1);
    const Eigen::MatrixXd u = q.Draws(standard);
    fresh->Prepare(u, false);
    fit_.counts += fresh->counts();
    const double volume = q.factor.diagonal().array().log().sum();
    const double scale =
        fresh->num_residuals() * std::log(fit_.sigma_px * std::sqrt(2 * std::numbers::pi));
    std::vector<double> weights;
    Eigen::VectorXd residual;
    for (int s = 0; s < options_.fresh_draws; ++s)
      if (fresh->Copy(s, &residual, nullptr))
        weights.push_back(0.5 * (standard.col(s).squaredNorm() - u.col(s).squaredNorm() -
                                 residual.squaredNorm()) +
                          volume - scale);
    fit_.fresh = static_cast<int>(weights.size());
    if (fit_.fresh < 25) return;
    const Eigen::Map<const Eigen::VectorXd> w(weights.data(), fit_.fresh);
    fit_.elbo = w.mean();
    fit_.elbo_error = std::sqrt((w.array() - fit_.elbo).square().mean() / fit_.fresh);
    fit_.pareto_k = ParetoShape(w);
    KeepDrapes(mean.Shapes(0));
  }

  // In the order of the problem's targets from that of the specimens.
  void KeepDrapes(const std::vector<Eigen::VectorXd>& by_specimen) {
    fit_.shapes.resize(by_specimen.size());
    std::size_t next = 0;
    for (int p = 0; p < fit_.hierarchy.specimens; ++p)
      for (std::size_t i = 0; i < fit_.specimen.size(); ++i)
        if (fit_.specimen[i] == p) fit_.shapes[i] = by_specimen[next++];
    for (const int p : fit_.specimen)
      fit_.materials.push_back(
          TableParametrisation(fit_.hierarchy.base, fit_.hierarchy.LogEntries(p))
              .Material(fit_.posterior.posterior.mean));
  }

  static constexpr double kModeShare = 0.3, kFitShare = 0.95;  // of the time

  const FitProblem& problem_;
  const StagedFitOptions& staged_;
  const PosteriorOptions& options_;
  const StagedFitCallbacks& callbacks_;
  const BranchFitter branch_fitter_;
  std::vector<std::vector<Target>> targets_;  // of each specimen
  Eigen::VectorXd mean_;
  PosteriorFit fit_;
};

}  // namespace

void PosteriorOptions::Check(std::size_t targets) const {
  CHECK_GE(specimen_stretch_sigma, 0.0);
  CHECK_GE(specimen_bend_sigma, 0.0);
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
  return PosteriorFitter(problem, staged, options, branch, callbacks).Run();
}

}  // namespace drape
