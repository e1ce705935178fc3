// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/posterior/map_estimator.h"

namespace drape {

// Model bdp after the mode: means and deviations of the elements.
[[nodiscard]] bool FitElements(const FitProblem& problem, const PosteriorOptions& options,
                               MapEstimator& mode, PosteriorFit* fit);

}  // namespace drape
