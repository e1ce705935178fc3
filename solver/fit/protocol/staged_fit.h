// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/fit/protocol/fit_types.h"

namespace drape {

// The protocol [METHODS, P18] for one material and its images. Many drapes are stable and the trust
// region stays in its basin. So a grid of stretch × bend factors × start shapes on a coarse cloth
// is ranked by outline, and the best guesses are settled on the fine cloth and fitted by Ceres in
// rounds: each round keeps the best candidates of the one before and spends more iterations on
// them. The second round first tries the initial guesses again with the material fitted so far, and
// takes those that come nearer to their images. The candidates of a round are fitted side by side,
// so their rollouts make batches (RunBatched); neither results nor the order of calls depend on
// that.

// Runs from `state` to the end or until it is cancelled, and returns the state then. Its best
// candidate (Best) is the fit; after a cancel it is the best so far.
StagedFitState RunStagedFit(const FitProblem& problem, const StagedFitOptions& options,
                            StagedFitState state, const StagedFitControl& control);

// The number of candidates of the present round that are done.
int DoneCandidates(const StagedFitState& state);

// Of them, those that have a result.
int SucceededCandidates(const StagedFitState& state);

// The valid candidate of least cost, or nullptr.
const FitCandidate* Best(const StagedFitState& state);

}  // namespace drape
