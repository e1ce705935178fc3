// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "physics/util/math/power_law.h"
#include "solver/fit/continuation.h"
#include "solver/fit/outline_residuals.h"

namespace drape {

// Where gradients of a drape fail. All are derivatives of the shape x by one number s along a line
// of materials: a parametrisation with P = 1, at s = 0.

struct GradientError {
  double step = 0.0;   // of the central difference, in s
  double size = 0.0;   // root mean square over the vertices of |∂x/∂s| by the tangent [m]
  double error = 0.0;  // ‖difference − tangent‖ / ‖tangent‖; NaN where a drape fails
};

// Of the shape after the steps of `rollout`, or of the equilibrium near the start. Both drapes of a
// difference start as the drape itself does: from `start`. Empty where it has no tangent.
std::vector<GradientError> CompareDifferences(Backend& backend, const MaterialParametrisation& line,
                                              const State& start, SolveMode integrator,
                                              const RolloutOptions& rollout,
                                              std::span<const double> steps);

// How the derivative grows towards the end of a branch. At a fold s* the lowest eigenvalue goes as
// (s* − s)^½ and |∂x/∂s| as its inverse, (s* − s)^−½.
struct FoldApproach {
  std::vector<double> distance, stiffness, speed;  // s* − s > 0, λ₁ [s⁻²], rms |∂x/∂s| [m]
  std::optional<PowerLaw> speed_by_distance, speed_by_stiffness;
};
// Of a branch that ended, its last points within `range` of the end (a share of the speed's growth:
// those with speed ≥ largest/range); s* by ContinuationResult::fold_estimate. None where the branch
// did not end or its speed does not grow.
std::optional<FoldApproach> FindFoldApproach(const ContinuationResult& path, double range);

}  // namespace drape
