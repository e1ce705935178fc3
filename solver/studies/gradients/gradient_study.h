// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "physics/util/math/power_law.h"
#include "solver/fit/continuation.h"
#include "solver/fit/outline_residuals.h"
#include "solver/studies/runner/study.h"

namespace drape {

// Where the gradients of a drape fail: differences against tangents, long horizons, and the ends of
// branches. All are derivatives of the shape x by one number s along a line of materials: a
// parametrisation with P = 1, at s = 0.

struct GradientError {
  double step = 0.0;   // of the central difference, in s
  double size = 0.0;   // root mean square over the vertices of |∂x/∂s| by the tangent [m]
  double error = 0.0;  // ‖difference − tangent‖ / ‖tangent‖; NaN where a drape fails
};

// The errors of the shape after the steps of `rollout`, or of the equilibrium near the start. Both
// drapes of a difference begin at `start`, as the drape itself does. Empty without a tangent.
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
// The last points of a branch that ended, those with speed ≥ largest/range; s* by
// ContinuationResult::fold_estimate. None where the branch did not end or its speed does not grow.
std::optional<FoldApproach> FindFoldApproach(const ContinuationResult& path, double range);

// The cloth of the study under one law.
struct StudiedCloth {
  std::string law;
  std::shared_ptr<const ClothModel> model;
  MaterialField material;
};

struct GradientStudyOptions {
  int start_seed = 3;
  std::vector<int> horizons = {1, 3, 10, 30, 100, 300, 1000};
  std::vector<double> time_steps = {0.02, 0.05, 0.1};  // [s]
  int fold_starts = 6;                                 // branches that are followed to their ends
};

// The cells: for each law the errors over steps of the difference, for each law and time step the
// errors over horizons, and the branches, which are followed on the first cloth.
Study MakeGradientStudy(std::vector<StudiedCloth> cloths, const GradientStudyOptions& options);

}  // namespace drape
