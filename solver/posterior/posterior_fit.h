// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/run_control.h"
#include "solver/fit/protocol/staged_fit.h"
#include "solver/posterior/posterior_types.h"

namespace drape {

// Model bdp (PosteriorKind::kElements) [METHODS, P33]: the tables of all faces and hinges are
// independent samples η = m + s·ε on the log scale, of means m and deviations s that all elements
// share. The fit is by its bound on ln p(r, m, s):
//   E_ε ln p(r | η) − KL(q(η | m, s) ‖ p(η | m, s)) + ln p(m, s).
// The variational density of the elements is their own conditional prior, so their divergence is
// zero, whatever their count, and E_ε is taken inside the residuals. What remains is the prior of
// 78 numbers, counted once: in units of their scales, m is standard normal and s has the Rayleigh
// density s·exp(−s²/2). −ln of it, relative to its peak, is
//   ½ Σ m² + ½ Σ (s² − 1 − ln s²),
// term by term the divergence of N(m, s²) from N(0, 1), which the shared cost already has as
// squares. (Were N(0, 1) the prior of each element, this would count once for each of thousands of
// elements and outweigh the images.) m and s are points: their own uncertainty is not included.
// `elbo` is that bound, relative to the peak of the prior; only ε is random, and its importance
// weights p(r | η) give k̂.

// Starts from the tables and drapes of a candidate. The prior is about the tables of its initial
// guess, as in the fit before, with the tying and prior_sigma of `staged`. First the mode, then the
// distribution.
PosteriorFit FitDrapePosterior(const FitProblem& problem, const StagedFitOptions& staged,
                               const PosteriorOptions& options, const FitCandidate& candidate,
                               const RunControl& control);

}  // namespace drape
