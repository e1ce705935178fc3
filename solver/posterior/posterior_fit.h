// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "solver/fit/protocol/staged_fit.h"
#include "solver/posterior/posterior_io.h"
#include "solver/posterior/samples/hierarchical_samples.h"
#include "solver/posterior/variational/variational_fit.h"

namespace drape {

// How sure a fit is [METHODS, P30]: a posterior over a fabric's tables and
// its specimens' scales, given the branches of their drapes.
struct PosteriorOptions {
  PosteriorKind kind = PosteriorKind::kHierarchy;
  // Prior standard deviations of a specimen's log factors on stretch and on bend; both 0: specimens
  // are alike. Trials gave 0.07 to 0.17 [METHODS, P41].
  double specimen_stretch_sigma = 0.1, specimen_bend_sigma = 0.1;
  std::vector<int> specimen;  // of each target, from 1 without gaps; empty: each its own
  // Whether σ of the outline is learned: from the outlines that the mode leaves unexplained, so
  // that what the model cannot do widens the posterior. Else it is StagedFitOptions::sigma_px.
  bool estimate_sigma = true;
  // kElements: scale of the prior of an entry's standard deviation over the elements (log factor).
  double element_sigma = 0.3;
  int angles = 36;         // K of r(θ): a silhouette's are not independent nearer than its folds
  int draws = 16;          // S, even
  int rank = 8;            // leading directions with correlations beyond the Laplace axes
  int iterations = 20;     // of Ceres
  int elbo_samples = 100;  // for the evidence lower bound and k̂, at least 25
  uint64_t seed = 1;

  void Check(std::size_t targets) const;  // programmer errors
};

struct PosteriorFit {
  PosteriorKind kind = PosteriorKind::kHierarchy;
  HierarchicalModel hierarchy;  // kElements: its fabric, all specimens alike
  VariationalFit mode;          // with the Laplace approximation
  // kElements: mean and standard deviation of each face and hinge, in units of the fabric's prior.
  VariationalFit posterior;
  double sigma_px = 0.0;  // of the outline, given or learned
  // Evidence lower bound by fresh draws [nat] and its standard error; k̂ of their importance
  // weights: below 0.7 the posterior is near enough to trust. kElements: of ln p(r, m, s), below.
  // NaN where fewer than 25 of these draws stand: then nothing vouches for the posterior.
  double elbo = 0.0, elbo_error = 0.0, pareto_k = 0.0;
  int fresh = 0;             // of these draws, with drapes that stand; the others count nowhere
  double draw_rms_px = 0.0;  // root mean square of their outlines against the images
  int beyond = 0;  // of the posterior's draws, with a drape beyond its branch: carried on straight
  RolloutCounts counts;
  std::vector<int> specimen;  // of each target, from 0
  // Of each target at the posterior's mean, or where that lies beyond the branch of one, at the
  // mode.
  bool shown_at_mode = false;
  std::vector<MaterialField> materials;
  std::vector<Eigen::VectorXd> shapes;  // the drapes there [m], shape [3V]

  bool valid() const { return !shapes.empty(); }
  // Tables of the fabric at u, without those of its specimens.
  MaterialField FabricAt(const Eigen::VectorXd& u) const;
  // The median of the posterior.
  MaterialField Fabric() const { return FabricAt(posterior.gaussian.mean); }
};

// Model bdp (PosteriorKind::kElements) [METHODS, P33]: the tables of all faces and hinges are
// independent draws η = m + s·ε on the log scale, of means m and deviations s that all elements
// share. The fit is by its bound on ln p(r, m, s):
//   E_ε ln p(r | η) − KL(q(η | m, s) ‖ p(η | m, s)) + ln p(m, s).
// The variational density of the elements is their own conditional prior, so their divergence is
// zero, whatever their count, and E_ε is taken inside the residuals. What is left is the prior of
// 78 numbers, counted once: in units of their scales, m is standard normal and s has the Rayleigh
// density s·exp(−s²/2). −ln of it, relative to its peak, is
//   ½ Σ m² + ½ Σ (s² − 1 − ln s²),
// term by term the divergence of N(m, s²) from N(0, 1), which the shared cost already has as
// squares. (Were N(0, 1) the prior of each element, this would count once for each of thousands of
// elements, and the images would say nothing.) m and s are points: their own uncertainty is not in
// it. `elbo` is that bound, relative to the peak of the prior; what is random is ε alone, whose
// importance weights p(r | η) give k̂.

// Goes on from the tables and drapes of a branch: the prior is about the seed's tables, as in the
// fit before, with the tying and prior_sigma of `staged`. First the mode, then the distribution.
PosteriorFit FitDrapePosterior(const FitProblem& problem, const StagedFitOptions& staged,
                               const PosteriorOptions& options, const FitCandidate& branch,
                               const StagedFitCallbacks& callbacks);

}  // namespace drape
