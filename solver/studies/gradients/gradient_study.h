// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "physics/simulation/statics/statics.h"
#include "solver/fit/parametrisation.h"
#include "solver/fit/rollout_residuals.h"
#include "solver/studies/runner/study.h"

namespace drape {

// One drape followed along a line of materials, θ(s) = s·direction from s = 0: Euler predictor by
// the implicit tangent, Newton corrector, steps by the error of the prediction [Allgower
// 1990, ch. 2 and 6]. The branch may end on the way: at a fold ∂x/∂s grows as (s* − s)^−½ and K
// loses definiteness; at a bifurcation K loses it while ∂x/∂s stays finite.

struct ContinuationOptions {
  double end = 1.0;  // of s, either sign, not 0
  double first_step = 0.02;
  double min_step = 1e-4;  // the branch counts as ended when a shorter one would be needed
  double max_step = 0.2;
  double max_error = 2e-3;  // a vertex further than this from its prediction is another branch [m]
  EquilibriumOptions corrector;

  void Check() const;  // programmer errors
};

enum class ContinuationStatus {
  kReachedEnd,
  kFold,     // the branch ends: see lost_at
  kNoStart,  // no stable drape near the start
  kCancelled
};
constexpr auto EnumNames(ContinuationStatus) {
  using enum ContinuationStatus;
  return MakeNames<ContinuationStatus>({{kReachedEnd, "reached the end"},
                                        {kFold, "the branch ends"},
                                        {kNoStart, "no stable drape at the start"},
                                        {kCancelled, "cancelled"}});
}

// A stable drape on the branch.
struct ContinuationPoint {
  double s = 0.0;
  Eigen::VectorXd x;       // [m], shape [3V]
  double speed = 0.0;      // root mean square over the vertices of |∂x/∂s| [m]
  double stiffness = 0.0;  // lowest eigenvalue of K by mass, as in LowestEigenvalues [s⁻²]
  double prediction_error = 0.0;  // largest distance of a vertex to its prediction [m]
};

struct ContinuationResult {
  ContinuationStatus status = ContinuationStatus::kNoStart;
  std::vector<ContinuationPoint> points;  // from s = 0; the last is the farthest
  int refused = 0;                        // rejected steps
  // The branch ends between the last point and lost_at (kFold).
  double lost_at = 0.0;
  // Where the speeds of the last two points put a fold (1/speed² is linear in s before it); none
  // where the speed does not grow.
  std::optional<double> fold_estimate;
};

// x: near the drape at s = 0, shape [3V]; direction: shape [P] of the parametrisation's θ.
ContinuationResult FollowBranch(StepSolver& solver, const MaterialParametrisation& parametrisation,
                                const Eigen::VectorXd& direction, const Eigen::VectorXd& x,
                                const ContinuationOptions& options);

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
