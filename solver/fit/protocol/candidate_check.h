// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/fit/protocol/fit_types.h"

namespace drape {

// Whether a candidate with shapes that was read from a file can be a result of this fit. Throws
// InputError (prefix `where`) when
// - its tables are not finite, or lose a resistance that those of its base have;
// - a shape is torn or crushed, has no outline or, in a static fit, is not at rest under the
// tables;
// - cost or profile_rms differs from that of the shapes and of theta.
// CHECKs the shapes of theta, [P], and of the shapes, [3V] for each observation.
void CheckCandidate(const FitProblem& problem, const StagedFitOptions& options,
                    const FitCandidate& candidate, const std::string& where);

}  // namespace drape
